// How near vertices, points and beams of paths must be to be merged, and how many of them that makes: functions of the
// place and the sample's index alone, so that all paths agree on them. Radii shrink with the samples by the dimension of
// what they span: a disk or cylinder (2D), a ball (3D), the gap between two beams (1D). Included per target.
#include <kinora/path_densities.h>
#include <kinora/random.h>

#if defined(KINORA_VCM_NEIGHBOURHOODS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VCM_NEIGHBOURHOODS_H_TARGET
#undef KINORA_VCM_NEIGHBOURHOODS_H_TARGET
#else
#define KINORA_VCM_NEIGHBOURHOODS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
class Neighbourhoods {
 public:
  // lightPaths: of a sample.
  Neighbourhoods(Group* group, const Services* services, const vcm::Options& options, float lightPaths)
      : g_(group),
        sv_(services),
        o_(options),
        lightPaths_(lightPaths),
        shrunk_(shrunk(options.reduce, 2)),
        shareMerged_(shareMerged()),
        shareBeams_(shareBeams()) {
    for (int k = 0; k < 3; ++k) mediaShrunk_[k] = shrunk(options.mediaReduce, float(k + 1));
  }

  // By point of a context; null where nothing is merged, 0 where these are not.
  struct Of {
    float *radius,
        *count;        // of vertices to vertices; how many light paths one point is merged with that they reach with
                       // a density of 1 per area, in media by volume
    float* merges;     // PathDensities::throughVertex: in media path densities are without the extinction at
                       // vertices, which two paths that meet both have
    float* crossings;  // and so much times the sine between the two ways there: beams that cross
    float* extinction[3];  // of points in media
  };
  Of of(const Context& c) const {
    Of n{};
    if (!o_.mergesAny() && !o_.beams) return n;
    for (float** x : {&n.radius, &n.count, &n.merges, &n.crossings}) {
      *x = c.alloc<float>(c.padded + kPad);
      std::fill_n(*x, c.padded + kPad, 0.f);
    }
    const bool isInSpace = c.traits & kTraitInSpace;
    if (!(isInSpace ? o_.mergesMedia || o_.beams : o_.merges)) return n;
    // points of a fibre stand on its axis, a line, of which a disk holds more or less than of a surface
    if (c.traits & kTraitFiber) return n;
    if (isInSpace) {
      MediumArgs medium{};
      for (int k = 0; k < 3; ++k) medium.extinction[k] = n.extinction[k] = c.alloc<float>(c.padded);
      c.bxdf->medium(&c, &medium);
    }
    for (uint32_t i = 0; i < c.count; ++i) {
      const float P[3] = {c.P[0][i], c.P[1][i], c.P[2][i]};
      if (!isInSpace) {
        const float r = n.radius[i] = radiusAt(P, o_.radius * shrunk_);
        n.count[i] = n.merges[i] = withinTime(shareMerged_, c.time[i]) * kPi * r * r;
        continue;
      }
      const float mean = (n.extinction[0][i] + n.extinction[1][i] + n.extinction[2][i]) * (1.f / 3);
      const InMedium m = inMedium(P, c.time[i], mean);
      n.radius[i] = m.ball;
      n.count[i] = m.points;
      n.merges[i] = m.merges;
      n.crossings[i] = m.crossings;
    }
    return n;
  }
  // At a place in a medium of that mean extinction.
  struct InMedium {
    float ball, disk, gap;         // radii
    float points, cylinder, wide;  // counts, see Of::count: points of points; points of beams, and beams of points;
                                   // beams of beams
    float merges, crossings;       // as Of
  };
  InMedium inMedium(const float P[3], float time, float extinction) const {
    InMedium m{};
    if (!(extinction > 0)) return m;
    if (o_.mergesMedia) {
      m.ball = radiusAt(P, o_.mediaRadius * mediaShrunk_[2]);
      m.points = withinTime(shareMerged_, time) * 4 * kPi / 3 * m.ball * m.ball * m.ball;
    }
    if (o_.beams) {
      m.disk = radiusAt(P, o_.mediaRadius * mediaShrunk_[1]);
      m.gap = radiusAt(P, o_.mediaRadius * mediaShrunk_[0]);
      const float n = withinTime(shareBeams_, time);
      m.cylinder = n * kPi * m.disk * m.disk;
      m.wide = n * 2 * m.gap;
    }
    m.merges = m.points * extinction + 2 * m.cylinder;
    m.crossings = m.wide / extinction;
    return m;
  }
  // The most that the radii of beams may be along a ray between two distances.
  float widest(const float o[3], const float d[3], float from, float to) const {
    float most = 0;
    for (const float t : {from, to}) {
      const float P[3] = {o[0] + d[0] * t, o[1] + d[1] * t, o[2] + d[2] * t};
      most = std::max(most, radiusAt(P, o_.mediaRadius * std::max(mediaShrunk_[0], mediaShrunk_[1])));
    }
    return most;
  }

  // Of(...).merges and crossings for a direction of points i, i + 1, ...; null arrays: 0.
  template <int V>
  static KN_INLINE Float<V> mergesOf(const Of& n, const Context& c, uint32_t i, Vec3<V> wi) {
    if (!n.merges) return Float<V>(0.f);
    return Float<V>::load(n.merges + i) + Float<V>::load(n.crossings + i) * sineOf(Vec3<V>::load(c.wo, i), wi);
  }
  template <int V>
  static KN_INLINE Float<V> sineOf(Vec3<V> a, Vec3<V> b) {
    const Float<V> cosine = dot(a, b);
    return safeSqrt(Float<V>(1.f) - cosine * cosine);
  }

  // Whether the path in a slot is one of those that are merged, and of those that leave beams.
  bool isMerged(uint32_t slot) const { return o_.mergesAny() && drawn(slot) < shareMerged_; }
  bool leavesBeams(uint32_t slot) const { return o_.beams && drawn(slot) < shareBeams_; }

 private:
  // Light paths through a disk of merging, were those of a sample spread evenly over the picture; beams over one.
  static constexpr float kMergesWanted = 8, kBeamsWanted = 8;

  float shrunk(float reduce, float dimension) const {
    return std::pow(float(g_->paths.sampleIndex[0]) + 1, (reduce - 1) / dimension);
  }
  // pixels: there.
  float radiusAt(const float P[3], float pixels) const {
    float d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const float d = P[k] - sv_->cameraCenter[k];
      d2 += d * d;
    }
    const float pixel = sv_->pixelSize + std::sqrt(d2) * sv_->pixelAngle;
    return std::clamp(pixels * pixel, 1e-6f * sv_->worldRadius, sv_->worldRadius);
  }
  // The share of a sample's light paths that are merged at all: with all of them a point would meet some hundred of
  // them under the wide radii of the first samples, which say little more than a few.
  float shareMerged() const {
    const float pixels = kPi * o_.radius * shrunk_ * o_.radius * shrunk_;
    return o_.kept * (o_.merges ? std::min(1.f, kMergesWanted / pixels) : 1.f);
  }
  // A beam as long as the picture's diagonal covers twice its radius times that of it.
  float shareBeams() const {
    if (!o_.beams) return 0;
    const float wide = float(sv_->resolution[0]), high = float(sv_->resolution[1]);
    const float radius = o_.mediaRadius * shrunk(o_.mediaReduce, 1);
    return o_.kept * std::min(1.f, kBeamsWanted / std::max(2 * radius * std::sqrt(wide * wide + high * high), 1e-6f));
  }
  float drawn(uint32_t slot) const {
    Float<1> unused, v;
    draw2(sv_->samples, Int<1>(g_->paths.sampleSeed[slot]), Int<1>(g_->paths.sampleIndex[slot]),
          dimensionAt(0) + kDimUser, unused, v);
    return v.lane0();
  }
  float withinTime(float share, float time) const {
    return lightPaths_ * share * (std::min(time + o_.timeRadius, 1.f) - std::max(time - o_.timeRadius, 0.f));
  }

  Group* g_;
  const Services* sv_;
  const vcm::Options& o_;
  float lightPaths_;
  float shrunk_, mediaShrunk_[3];  // radii of this sample, as a share of the first one's; in media by dimension
  float shareMerged_, shareBeams_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
