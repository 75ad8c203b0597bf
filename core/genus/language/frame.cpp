#include "genus/language/frame.h"

#include <array>
#include <cstdlib>
#include <new>

namespace genus::language {

namespace {

constexpr std::uint32_t kPooledSlots = 64;

// Frames come and go with every call, so freed ones are kept by size.
struct Pool {
    std::array<void*, kPooledSlots + 1> free{};

    ~Pool()
    {
        for (void* first : free)
            while (first) {
                void* next = *static_cast<void**>(first);
                std::free(first);
                first = next;
            }
    }
};
thread_local Pool t_pool;
thread_local Frame* t_captured = nullptr;

std::size_t bytes_of(std::uint32_t n_slots)
{
    return sizeof(Frame) + n_slots * sizeof(Value);
}

void* allocate(std::uint32_t n_slots)
{
    if (n_slots <= kPooledSlots && t_pool.free[n_slots]) {
        void* memory = t_pool.free[n_slots];
        t_pool.free[n_slots] = *static_cast<void**>(memory);
        return memory;
    }
    void* memory = std::malloc(bytes_of(n_slots));
    if (!memory) throw std::bad_alloc();
    return memory;
}

void unlink(Frame* frame)
{
    if (frame->previous_captured)
        frame->previous_captured->next_captured = frame->next_captured;
    else
        t_captured = frame->next_captured;
    if (frame->next_captured) frame->next_captured->previous_captured = frame->previous_captured;
}

}  // namespace

Frame* make_frame(std::uint32_t n_slots, Frame* parent)
{
    charge_value_memory(bytes_of(n_slots));
    auto* frame = static_cast<Frame*>(allocate(n_slots));
    frame->references = 1;
    frame->type = Object::Type::Frame;
    frame->n_slots = n_slots;
    frame->parent = parent;
    if (parent) ++parent->references;
    frame->instance = nullptr;
    frame->captured = false;
    for (std::uint32_t i = 0; i < n_slots; ++i) new (frame->slots() + i) Value(Value::unset());
    return frame;
}

void free_frame(Frame* frame) noexcept
{
    release_value_memory(bytes_of(frame->n_slots));
    if (frame->captured) unlink(frame);
    if (frame->n_slots > kPooledSlots) {
        std::free(frame);
        return;
    }
    void*& first = t_pool.free[frame->n_slots];
    *reinterpret_cast<void**>(frame) = first;
    first = frame;
}

void capture(Frame* frame)
{
    // With those around it, which it holds: a circle may close in any of them.
    for (; frame && !frame->captured; frame = frame->parent) {
        frame->captured = true;
        frame->previous_captured = nullptr;
        frame->next_captured = t_captured;
        if (t_captured) t_captured->previous_captured = frame;
        t_captured = frame;
    }
}

void clear_captured_frames()
{
    while (t_captured) {
        Frame* frame = t_captured;
        ++frame->references;
        FrameHold hold(frame);
        unlink(frame);
        frame->captured = false;
        for (std::uint32_t i = 0; i < frame->n_slots; ++i) frame->slots()[i] = Value();
    }
}

}  // namespace genus::language
