#include "render/frame_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/memory.h"
#include "render/frame.h"

namespace kinora::render {

void FrameSamples::begin(const film::Window& window, bool hasNoise, const scene::Scene& scene,
                         Diagnostics& diagnostics) {
  active_ = ActivePixels(window);
  noise_.reset();
  if (counts_.adaptivity.error > 0 && !hasNoise) {
    counts_.last = std::min(counts_.last, counts_.first + kUsualSamples);
    diagnostics.warning("RENDER-ADAPTIVE", scene.pos,
                        "an error is asked for, and the picture has no colour to measure it by",
                        "every pixel takes " + std::to_string(counts_.last - counts_.first) + " samples");
  }
  if (counts_.adaptivity.isOn() && hasNoise) {
    noise_ = std::make_unique<NoiseEstimate>(active_.blocks());
    convergence_ = Convergence(counts_.adaptivity, counts_.first, counts_.last - counts_.first, active_.blocks());
  }
  done_ = recovered_ = 0;
  taken_ = takenAtDecision_ = takenBefore_ = 0;
}

void FrameSamples::goOn(const Checkpoints::Recovered& recovered) {
  recovered_ = recovered.samples;
  takenBefore_ = recovered.taken;
  takenAtDecision_ = taken_;
}

std::vector<film::SampleRange> FrameSamples::ranges() const {
  if (counts_.stride == 1) return {{uint32_t(counts_.first), uint32_t(counts_.first + done_)}};
  std::vector<film::SampleRange> ranges;
  for (int k = 0; k < done_; ++k) {
    const uint32_t index = uint32_t(counts_.first + k * counts_.stride);
    ranges.push_back({index, index + 1});
  }
  return ranges;
}

int FrameSamples::passEnd(const PassLimits& limits) const {
  const int a = next();
  if (counts_.stride > 1) return a + 1;
  int b = counts_.last;
  for (const auto& [from, to] : Frame::passes(counts_.first, counts_.last, limits.most))
    if (to > a) {
      b = to;
      break;
    }
  if (limits.areCachesCrowded && !noise_ && !limits.isFixed)
    b = std::min(counts_.last, (a / Frame::kMostSamplesOfPass + 1) * Frame::kMostSamplesOfPass);
  constexpr int kLeast = 4;  // smaller passes would not fill a ray group
  if (!std::isfinite(limits.longest) || done_ == recovered_ || limits.isFixed) return b;
  const double perSample = limits.seconds / (done_ - recovered_);
  if ((b - a) * perSample <= limits.longest) return b;
  return std::min(b, a + std::max(kLeast, int(limits.longest / perSample)));
}

void FrameSamples::passDone(int end) {
  const int begin = next();
  taken_ += uint64_t(end - begin) * active_.count();
  done_ += end - begin;
  if (noise_ && isDecisionPoint(end)) {
    convergence_.decide(*noise_, end, active_);
    takenAtDecision_ = taken_;
  }
}

Progress FrameSamples::progress(double seconds) const {
  Progress p;
  p.samplesDone = done_;
  p.samplesWanted = counts_.count();
  p.memoryBytes = Memory::resident();
  const double taken = double(taken_), most = double(p.samplesWanted - done_) * double(active_.count());
  // adaptive: what the last decision expects, as far as it has not been taken since
  const bool isExpected = noise_ && convergence_.samplesLeft() >= 0;
  const double left =
      isExpected ? std::clamp(convergence_.samplesLeft() - double(taken_ - takenAtDecision_), 0., most) : most;
  p.seconds = seconds;
  p.isErrorWanted = counts_.adaptivity.error > 0;
  if (p.isErrorWanted) p.error = convergence_.error();
  if (p.isErrorWanted && !isExpected) return p;  // nobody knows yet
  p.fraction = taken / std::max(1.0, taken + left);
  const double takenNow = taken - double(takenBefore_);
  p.secondsLeft = takenNow > 0 ? seconds / takenNow * left : -1;
  return p;
}

void FrameSamples::tellOfNoise(const scene::Scene& scene, Diagnostics& diagnostics) const {
  const float wanted = counts_.adaptivity.error;
  if (!noise_ || wanted <= 0 || active_.count() == 0) return;
  diagnostics.warning("RENDER-NOISE", scene.pos,
                      fmt::format("after {} samples a pixel the picture's relative error is about {:.3g}, and {:.3g} "
                                  "was asked for",
                                  done_, convergence_.error(), wanted),
                      "the picture is written", "--max-spp allows more samples");
}

}  // namespace kinora::render
