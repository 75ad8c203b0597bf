#include "genus/model/widen.h"

#include <algorithm>
#include <cmath>

#include "genus/base/progress.h"
#include "genus/model/changes.h"
#include "genus/model/shaper.h"

namespace genus {

namespace {

constexpr double kTurn = 0.55;      // of normals along an edge, in radians, at most
constexpr double kShort = 0.75;     // edges that are to go, beside that
constexpr double kLong = 1.4;       // edges that may be left, beside that
constexpr double kRound = 0.15;     // height over longest side after a collapse
constexpr double kCosine = 0.82;    // between a face and the exact normals at its corners
constexpr double kFlatCurve = 0.1;  // sagitta of a curve, of the height of its faces
constexpr double kGain = 1.1;       // by a flip
constexpr int kRounds = 3, kMoves = 3;

class Widener : Shaper {
public:
    Widener(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms, double max_error,
            double flat_enough)
        : Shaper(mesh, forms), max_error_(max_error), flat_enough_(flat_enough), changes_(mesh)
    {
    }

    void run()
    {
        for (int round = 0; round < kRounds; ++round) {
            current_progress().check();
            std::size_t done = 0;
            for (const std::int32_t s : short_edges()) {
                if (!m_.alive(s) || !changes_.at_edge(s) || bend(s) >= kShort) continue;
                const std::int32_t a = m_.from(s), b = m_.to(s);
                if (!collapsed(s) && !collapsed(m_.twin(s))) continue;
                changes_.note_collapse(a, b);
                ++done;
            }
            flip_all();
            changes_.next_round();
            if (done == 0) break;
        }
        for (int round = 0; round < kMoves; ++round) {
            for (std::int32_t v = 0; v < static_cast<std::int32_t>(m_.n_vertices()); ++v)
                if (m_.exists(v)) centre(v);
            flip_all();
            changes_.next_round();
        }
    }

private:
    // How much the normals of a surface turn from p to q beside what they may, or how far the
    // surface is from the chord.
    double bend(std::int32_t label, const Vec3& p, const Vec3& q) const
    {
        const SurfaceForm& form = forms_[label >> 1];
        if (form.is_plane()) return 0.0;
        const double turn = norm(normalized(form.gradient(q)) - normalized(form.gradient(p)));
        return std::max(turn / kTurn, std::sqrt(0.125 * turn * distance(p, q) / max_error_));
    }

    double bend(std::int32_t s) const
    {
        const Vec3 &p = m_.point(m_.from(s)), &q = m_.point(m_.to(s));
        const double left = bend(m_.label(s), p, q);
        return m_.is_crease(s) ? std::max(left, bend(m_.label(m_.twin(s)), p, q)) : left;
    }

    std::vector<std::int32_t> short_edges() const
    {
        std::vector<std::pair<double, std::int32_t>> found;
        for (std::int32_t s = 0; s < m_.n_sides(); ++s) {
            if (!m_.alive(s) || m_.twin(s) < s) continue;
            const double ratio = bend(s);
            if (ratio < kShort) found.emplace_back(ratio, s);
        }
        std::sort(found.begin(), found.end());
        std::vector<std::int32_t> sides;
        for (const auto& [ratio, s] : found) sides.push_back(s);
        return sides;
    }

    // Height over longest side, 0 if a normal at a corner differs too much or the surface is too
    // far.
    double roundness(const Vec3& a, const Vec3& b, const Vec3& c, std::int32_t label) const
    {
        const Shape here = shape(a, b, c, label, kCosine);
        if (!here.faces_right) return 0.0;
        const SurfaceForm& form = forms_[label >> 1];
        if (!form.is_plane()) {
            const Interval far = SurfaceForm::deviation_of(form.bends({a, b, c}));
            const double least = norm(form.gradient((a + b + c) / 3.0));
            if (!(std::max(-far.lo, far.hi) <= max_error_ * least)) return 0.0;
        }
        return here.height_ratio;
    }

    double roundness(std::int32_t s) const
    {
        return roundness(m_.point(m_.from(s)), m_.point(m_.to(s)), m_.point(m_.apex(s)),
                         m_.label(s));
    }

    bool collapsed(std::int32_t s)
    {
        const std::int32_t a = m_.from(s), b = m_.to(s);
        if (m_.touches(a) || !kind_allows(s) || !m_.can_collapse(s)) return false;
        const bool along_curve = m_.is_crease(s);
        bool fits = true;
        double after = 1.0;
        m_.visit_ring(a, [&](std::int32_t x) {
            if (!fits || m_.to(x) == b) return;
            const Vec3 &p = m_.point(m_.to(x)), &q = m_.point(m_.apex(x));
            if (along_curve && m_.is_crease(x)) fits = flat_curve(x, m_.point(b));
            if (m_.apex(x) == b) return;
            fits = fits && bend(m_.label(x), m_.point(b), p) <= kLong;
            if (fits) after = std::min(after, roundness(m_.point(b), p, q, m_.label(x)));
            fits = fits && after > 0.0;
        });
        if (fits && after < kRound) fits = after > least_roundness(a);
        if (!fits) return false;
        m_.collapse(s);
        return true;
    }

    double least_roundness(std::int32_t v) const
    {
        double least = 1.0;
        m_.visit_ring(v, [&](std::int32_t x) { least = std::min(least, roundness(x)); });
        return least;
    }

    // Whether the curve stays flat beside its faces if it goes from p to the end of x.
    bool flat_curve(std::int32_t x, const Vec3& p) const
    {
        const Vec3& q = m_.point(m_.to(x));
        const double length = distance(p, q);
        double height = length;
        for (const std::int32_t side : {x, m_.twin(x)})
            height = std::min(height, norm(cross(q - p, m_.point(m_.apex(side)) - p)) / length);
        const Vec3 middle = 0.5 * (p + q);
        const std::int32_t left = m_.label(x) >> 1, right = m_.label(m_.twin(x)) >> 1;
        return std::max(forms_[left].distance(middle), forms_[right].distance(middle)) <=
                   flat_enough_ ||
               distance_from_curve(left, right, middle) <= kFlatCurve * height;
    }

    void flip_all()
    {
        for (std::int32_t s = 0; s < m_.n_sides(); ++s)
            if (m_.alive(s) && m_.twin(s) > s && changes_.round_edge(s)) flip_if_rounder(s);
    }

    void flip_if_rounder(std::int32_t s)
    {
        if (m_.is_crease(s)) return;
        const std::int32_t t = m_.twin(s);
        const Vec3 &a = m_.point(m_.from(s)), &b = m_.point(m_.to(s));
        const Vec3 &c = m_.point(m_.apex(s)), &d = m_.point(m_.apex(t));
        const double before = std::min(roundness(s), roundness(t));
        const double least = kGain * before;
        if (std::min(height_ratio(d, c, a), height_ratio(c, d, b)) <= least) return;
        if (roundness(d, c, a, m_.label(s)) > least && roundness(c, d, b, m_.label(s)) > least &&
            m_.flip(s))
            changes_.note_flip(s);
    }

    // Moves a vertex inside a face to the middle of its neighbours, if that makes its faces
    // rounder.
    void centre(std::int32_t v)
    {
        if (m_.touches(v) || m_.n_creases(v) > 0) return;
        Vec3 sum;
        double n = 0.0, after = 1.0;
        std::int32_t label = 0;
        m_.visit_ring(v, [&](std::int32_t s) {
            label = m_.label(s);
            sum += m_.point(m_.to(s));
            n += 1.0;
        });
        const SurfaceForm& form = forms_[label >> 1];
        const Vec3 middle = sum / n, way = normalized(form.gradient(middle));
        const auto t = form.root_along(middle, way);
        if (!t) return;
        const Vec3 p = form.straightened(middle + *t * way);
        m_.visit_ring(v, [&](std::int32_t s) {
            after = std::min(after, roundness(p, m_.point(m_.to(s)), m_.point(m_.apex(s)), label));
        });
        if (!(after > least_roundness(v))) return;
        m_.move(v, p);
        changes_.note_move(v);
    }

    double max_error_, flat_enough_;
    Changes changes_;
};

}  // namespace

void widen(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms, double max_error,
           double flat_enough)
{
    Widener(mesh, forms, max_error, flat_enough).run();
}

}  // namespace genus
