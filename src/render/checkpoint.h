// Checkpoints: a frame that was stopped is gone on with later, and has the bits that it would have had. A checkpoint is
// a part of the frame (film/shard.h) of the passes that are complete, with what adaptive sampling has found and decided
// so far; all else is a function of the samples' indices, and what is learned is learned again. Renderer writes and
// reads them between passes; which file, the program says.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "film/shard.h"
#include "render/adaptive.h"
#include "render/checkpointing.h"
#include "render/sample_counts.h"
#include "scene/scene.h"

namespace kinora::render {

// A frame's samples between two passes: the sums, and what adaptive sampling knows of them.
struct Sampled {
  film::Film& film;
  const SampleCounts& counts;
  int& samplesDone;        // of each pixel that still takes some
  uint64_t& samplesTaken;  // of all pixels
  ActivePixels& active;
  NoiseEstimate* noise;  // null: every pixel takes the same samples, and neither of the three counts
  Convergence& convergence;
};

// Those of one render.
class Checkpoints {
 public:
  // What the checkpoint before had.
  struct Recovered {
    int samples = 0;
    uint64_t taken = 0;
    double seconds = 0;
    std::vector<FileContents::Entry> files;  // that were met while its samples were taken
  };
  Checkpoints() = default;
  explicit Checkpoints(Checkpointing wanted) : wanted_(std::move(wanted)) {}
  const Checkpointing& wanted() const { return wanted_; }
  const Recovered& recovered() const { return recovered_; }

  // Whether there is a file to go on from; what recover() is to be given takes time.
  bool isThere() const;
  // Goes on from the file; `own`: of this frame. What it cannot go on from is told, and then nothing is changed.
  void recover(const Sampled& sampled, const film::ShardInfo& own, Diagnostics& diagnostics);
  // Before a pass, and when it is complete: between the two buckets are ahead of others, and fallBack() takes them back.
  void passBegins(const Sampled& sampled);
  void passEnds() { sums_.clear(); }
  void fallBack(const Sampled& sampled) const;
  // After a pass; times since the render began, in seconds. isAsked: by a signal.
  bool isDue(double seconds, bool isAsked) const;
  bool isOver(double seconds) const { return wanted_.isOn() && wanted_.exitAt.isOver(seconds, passes_); }
  // Of complete passes.
  void write(const Sampled& sampled, film::ShardInfo info, double seconds, Diagnostics& diagnostics);
  // The frame is complete, and its pictures are written.
  void remove() const;

 private:
  Checkpointing wanted_;
  Recovered recovered_;
  int passes_ = 0, passesThen_ = 0;  // begun; and at the last checkpoint
  double secondsThen_ = 0;
  std::vector<int64_t> sums_;  // of the film, before the running pass
  std::optional<NoiseEstimate> noise_;
};

}  // namespace kinora::render
