#include "render/sample_counts.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

namespace kinora::render {

namespace {

constexpr int kMostSamples = 1 << 16;
constexpr int kUsualAdaptive = 1024;  // where nothing says how many

// 0: the scene does not say.
int samplesOf(const scene::Scene& scene, Diagnostics& diagnostics) {
  int n = scene.hider ? scene.hider->params.getInt("maxsamples", 0) : 0;
  if (n < 0 || n > kMostSamples)
    diagnostics.warning("RENDER-SAMPLES", scene.hider->pos,
                        "maxsamples of the Hider is " + std::to_string(n) + ", which is not within 0 to " +
                            std::to_string(kMostSamples),
                        n < 0 ? "it is ignored" : std::to_string(kMostSamples) + " are taken");
  if (n <= 0 && scene.pixelSamples[0] > 0) n = scene.pixelSamples[0] * std::max(1, scene.pixelSamples[1]);
  return std::clamp(n, 0, kMostSamples);
}

float varianceOf(const scene::Scene& scene, const Settings& settings) {
  if (settings.samplesPerPixel > 0) return 0;
  if (settings.pixelVariance >= 0) return settings.pixelVariance;
  const float own = scene.hider ? scene.hider->params.getFloat("pixelvariance", -1) : -1.f;
  const float v = own >= 0 ? own : scene.pixelVariance;
  return std::isfinite(v) && v > 0 ? v : 0;
}

constexpr int kMostStride = 4096;

// What the Hider says, or --set in its place: before a scene is loaded the latter is not in it.
int hiderInt(const scene::Scene& scene, const Settings& settings, const std::string& name, int fallback) {
  for (size_t i = settings.sets.size(); i-- > 0;)
    if (settings.sets[i].first == "hider." + name) return std::atoi(settings.sets[i].second.c_str());
  return scene.hider ? scene.hider->params.getInt(name, fallback) : fallback;
}

}  // namespace

// Of the part's range those indices count that are whole strides from the frame's first one.
PartIndices partIndicesOf(const scene::Scene& scene, const Settings& settings) {
  const int stride = hiderInt(scene, settings, "samplestride", 1);
  if (stride < 2 || stride > kMostStride) return {settings.firstSample, 1};
  const int offset = std::max(0, hiderInt(scene, settings, "sampleoffset", 0));
  const int phase = (offset % stride - settings.firstSample % stride + stride) % stride;
  return {settings.firstSample + phase, stride};
}

SampleCounts sampleCountsOf(const scene::Scene& scene, const Settings& settings, Diagnostics& diagnostics) {
  SampleCounts r;
  Adaptivity& a = r.adaptivity;
  if (settings.samplesPerPixel <= 0) a.error = settings.pictureError;
  a.variance = a.error > 0 ? 0 : varianceOf(scene, settings);
  const bool isPart = settings.firstSample >= 0;
  if (scene.hider) {
    r.first = std::clamp(scene.hider->params.getInt("sampleoffset", 0), 0, 1 << 20);
    r.stride = scene.hider->params.getInt("samplestride", 1);
    if (r.stride < 1 || r.stride > kMostStride) {
      diagnostics.warning("RENDER-SAMPLES", scene.hider->pos,
                          "samplestride of the Hider is " + std::to_string(r.stride) + ", which is not within 1 to " +
                              std::to_string(kMostStride),
                          "every sample is taken");
      r.stride = 1;
    }
  }
  if (r.stride > 1 && a.isOn()) {
    diagnostics.warning("RENDER-ADAPTIVE", scene.hider->pos,
                        "adaptive sampling is asked for, and the samples of the frame are one of " +
                            std::to_string(r.stride) + " (samplestride of the Hider)",
                        "every pixel takes all samples that the Hider names",
                        "parts by --crop keep adaptive sampling");
    a.variance = a.error = 0;
  } else if (isPart && a.isOn()) {
    // of a range that begins later nobody knows what the samples before it decided
    diagnostics.warning(
        "RENDER-ADAPTIVE", scene.pos,
        "the scene asks for adaptive sampling (PixelVariance), and this is a part of the frame's samples",
        "every pixel takes all samples of the part", "parts by --crop keep adaptive sampling");
    a.variance = a.error = 0;
  }
  int most = settings.samplesPerPixel > 0 ? settings.samplesPerPixel : settings.mostSamples;
  if (most <= 0 && a.error > 0) most = kMostSamples;
  if (most <= 0) most = samplesOf(scene, diagnostics);
  if (most <= 0) most = a.isOn() && settings.pixelVariance > 0 ? kUsualAdaptive : kUsualSamples;
  most = std::clamp(most, 1, kMostSamples);
  if (scene.hider) {
    const float dark = scene.hider->params.getFloat("darkfalloff", a.darkFalloff);
    if (std::isfinite(dark) && dark >= 0) a.darkFalloff = std::max(dark, 1e-6f);
  }
  r.last = r.first + (most - 1) * r.stride + 1;
  if (isPart) {
    r.first = partIndicesOf(scene, settings).first;
    r.last = settings.lastSample;
  }
  if (!a.isOn()) return r;
  // what the scene says fits its own bound of noise
  const bool isOfScene = settings.leastSamples <= 0 && a.error <= 0 && scene.hider;
  int least = isOfScene ? scene.hider->params.getInt("minsamples", 0) : std::max(settings.leastSamples, 0);
  if (least > most) {
    diagnostics.warning(
        "RENDER-ADAPTIVE", scene.hider ? scene.hider->pos : scene.pos,
        "the least number of samples, " + std::to_string(least) + ", is above the most, " + std::to_string(most),
        std::to_string(most) + " are taken everywhere");
    least = most;
  }
  // what two halves of fewer samples say of their error is too uncertain
  a.least =
      least > 0 ? std::max(least, 2) : std::min(most, a.error > 0 ? 16 : std::max(16, int(std::sqrt(double(most)))));
  return r;
}

}  // namespace kinora::render
