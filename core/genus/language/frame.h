#pragma once

#include "genus/language/value.h"

namespace genus::language {

struct ModuleInstance;

/// The variables of one run of a scope. Frames link to that of the enclosing scope, so a variable
/// is found by a number of steps outward and a slot.
struct Frame : Object {
    std::uint32_t n_slots;
    Frame* parent;             // counted; null for a file
    ModuleInstance* instance;  // the module this is the body of, else null
    Frame* previous_captured;  // list of the frames that functions hold on to
    Frame* next_captured;
    bool captured;

    Value* slots() { return reinterpret_cast<Value*>(this + 1); }
};
static_assert(sizeof(Frame) % alignof(Value) == 0);

/// A frame with all slots unset; adds a count to `parent`. Memory comes from a pool of the thread.
Frame* make_frame(std::uint32_t n_slots, Frame* parent);

/// Called by `destroy` once the slots are released.
void free_frame(Frame* frame) noexcept;

/// Notes that a function value holds `frame`, and so those around it.
void capture(Frame* frame);

/// Empties all frames that functions still hold, to break circles of functions and frames. Called
/// when a program has ended.
void clear_captured_frames();

/// Counted pointer to a frame.
class FrameHold {
public:
    FrameHold() = default;
    /// Takes over one count.
    explicit FrameHold(Frame* frame) noexcept : frame_(frame) {}
    FrameHold(FrameHold&& o) noexcept : frame_(std::exchange(o.frame_, nullptr)) {}
    FrameHold& operator=(FrameHold&& o) noexcept
    {
        std::swap(frame_, o.frame_);
        return *this;
    }
    FrameHold(const FrameHold&) = delete;
    FrameHold& operator=(const FrameHold&) = delete;
    ~FrameHold()
    {
        if (frame_ && --frame_->references == 0) destroy(frame_);
    }

    Frame* get() const { return frame_; }
    Frame* operator->() const { return frame_; }
    explicit operator bool() const { return frame_ != nullptr; }

private:
    Frame* frame_ = nullptr;
};

}  // namespace genus::language
