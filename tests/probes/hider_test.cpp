// A hider that fills sample records without the loop over rays, through the door that loop uses: positions, weights
// and all floats of the record, in buckets, from several threads. It misses a real one: micropolygons come later.
#include "render/hider.h"

#include <kinora/context.h>

#include <atomic>
#include <bit>

#include "render/services.h"
#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

constexpr int kWidth = 40, kHeight = 24, kSamples = 4;

// Float k of a sample: exact in the film's fixed point, different for every pixel, sample and float.
float valueOf(int x, int y, int sample, int k) { return float(x + 64 * y) / 4096 + float(sample) / 64 + float(k); }

class PatternHider final : public render::Hider {
 public:
  PatternHider(int floats, uint32_t atOnce) : floats_(floats), atOnce_(atOnce) {}
  mutable std::atomic<uint64_t> samples{0};

  void fill(render::Worker& w, const render::BucketSamples& b,
            const std::function<void(uint32_t)>& retire) const override {
    shade::GroupState& s = w.state();
    uint32_t n = 0;
    const auto flush = [&] {
      if (n) retire(n);
      samples += n;
      n = 0;
    };
    for (int sample = b.firstSample; sample < b.lastSample; ++sample)
      for (int y = b.y0; y < b.y1; ++y)
        for (int x = b.x0; x < b.x1; ++x) {
          if (!n) w.begin(atOnce_, StageKind::CameraPaths);
          s.pixelX()[n] = x;
          s.pixelY()[n] = y;
          s.group().paths.sampleIndex[n] = uint32_t(sample);
          s.weights()[n] = 1;
          for (int k = 0; k < floats_; ++k) w.records()[k][n] = valueOf(x, y, sample, k);
          if (++n == atOnce_) flush();
        }
    flush();
  }

 private:
  int floats_;
  uint32_t atOnce_;
};

const char* const kScene = R"(
Hider "raytrace" "int maxsamples" [4]
Display "probe.exr" "openexr" "Ci,a,z,Nn,directDiffuse"
DisplayChannel "color directDiffuse"
Format 40 24 1
Projection "perspective" "fov" [40]
WorldBegin
  Light "PxrDomeLight" "sky"
  Translate 0 0 4
  Sphere 1 -1 1 360
WorldEnd
)";

TEST(Hider, FillsRecordsWithoutTheRayLoop) {
  Workshop stage;
  std::vector<int64_t> first;
  for (const auto& [threads, atOnce] : {std::pair(1, 64u), std::pair(2, 256u), std::pair(2, 7u)}) {
    render::Settings s;
    s.threads = threads;
    const auto r = stage.load(sceneOf(kScene, stage.messages), s);
    const film::ChannelLayout& layout = r->film().layout();
    const PatternHider hider(layout.recordFloats(), atOnce);
    r->setHider(&hider);
    ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
    // buckets may reach beyond the picture: at least every sample in it
    EXPECT_GE(hider.samples.load(), uint64_t(kWidth * kHeight * kSamples));
    EXPECT_EQ(r->statistics().cameraRays, 0u);
    for (int c = 0; c < layout.size(); ++c) {
      const film::Channel& channel = layout[c];
      const image::Image picture = r->film().resolve(c);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
          for (int k = 0; k < channel.width; ++k) {
            double sum = 0, least = 1e30;
            for (int sample = 0; sample < kSamples; ++sample) {
              const double v = valueOf(x, y, sample, layout.recordOffset(c) + k);
              sum += v;
              least = std::min(least, v);
            }
            const double expected = channel.reducer == film::Reducer::Min ? least : sum / kSamples;
            ASSERT_NEAR(picture.at(x, y)[k], expected, 1e-6 * (1 + expected))
                << channel.name << " at " << x << "," << y;
          }
    }
    const std::vector<int64_t> state = stateOf(r->film());
    if (first.empty()) first = state;
    EXPECT_EQ(state, first) << "threads " << threads << ", " << atOnce << " samples at once";
    // and the loop over rays is back when the hider goes
    r->setHider(nullptr);
    r->film().clear();
    ASSERT_EQ(r->renderFilm(), render::Outcome::Complete);
    EXPECT_GE(r->statistics().cameraRays, uint64_t(kWidth * kHeight * kSamples));
    EXPECT_NE(stateOf(r->film()), first);
  }
}

}  // namespace
}  // namespace kinora::probes
