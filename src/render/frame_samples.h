// The samples of one render: which each pixel takes, which it has, and where adaptive sampling still wants some. Renderer
// takes its passes from here and tells it of each; it renders nothing itself.
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/diagnostics.h"
#include "film/shard.h"
#include "render/adaptive.h"
#include "render/checkpoint.h"
#include "render/renderer.h"
#include "render/sample_counts.h"

namespace kinora::render {

// What the length of a pass follows from beside the samples' indices. None of it changes a pixel.
struct PassLimits {
  int most = 0;          // samples, of an integrator that keeps records between stages; 0: it keeps none
  bool isFixed = false;  // the integrator's samples follow from where passes end
  bool areCachesCrowded = false;
  double longest = std::numeric_limits<double>::infinity();  // seconds until a picture or a checkpoint is due
  double seconds = 0;                                        // since the render began
};

class FrameSamples {
 public:
  // What the scene asks for, from begin() on. Set while a world is made.
  void setCounts(const SampleCounts& counts) { counts_ = counts; }
  const SampleCounts& counts() const { return counts_; }
  // No pixel of the window has a sample. hasNoise: noise can be measured; without it every pixel takes the same samples.
  void begin(const film::Window& window, bool hasNoise, const scene::Scene& scene, Diagnostics& diagnostics);
  // Those that a checkpoint had are there; `recovered`: of it.
  void goOn(const Checkpoints::Recovered& recovered);

  bool isAdaptive() const { return noise_ != nullptr; }
  NoiseEstimate* noise() const { return noise_.get(); }
  const ActivePixels& active() const { return active_; }
  const Convergence& convergence() const { return convergence_; }
  int done() const { return done_; }                                   // of each pixel that still takes some
  uint64_t taken() const { return taken_; }                            // of all pixels
  int next() const { return counts_.first + done_ * counts_.stride; }  // the first index that is not taken
  // Behind the last index that is taken.
  int end() const { return done_ ? counts_.first + (done_ - 1) * counts_.stride + 1 : counts_.first; }
  bool areLeft() const { return next() < counts_.last && active_.count() > 0; }
  // The indices that every pixel has taken.
  std::vector<film::SampleRange> ranges() const;
  // The samples as checkpoints see them, with the film that they are in.
  Sampled in(film::Film& film) { return {film, counts_, done_, taken_, active_, noise_.get(), convergence_}; }

  // Where the pass that begins at next() ends: passes end on the same counts however a frame is split, but one that would
  // take too long is cut, and where caches are crowded those to come are as long as passes get.
  int passEnd(const PassLimits& limits) const;
  // The pass up to `end` is complete.
  void passDone(int end);
  // What is left is at most what active pixels would still take.
  Progress progress(double seconds) const;
  // A frame that is complete and was to have less noise than it has.
  void tellOfNoise(const scene::Scene& scene, Diagnostics& diagnostics) const;

 private:
  SampleCounts counts_;
  int done_ = 0;
  uint64_t taken_ = 0;
  ActivePixels active_;
  std::unique_ptr<NoiseEstimate> noise_;
  Convergence convergence_;
  uint64_t takenAtDecision_ = 0;
  int recovered_ = 0;  // of done_
  uint64_t takenBefore_ = 0;
};

}  // namespace kinora::render
