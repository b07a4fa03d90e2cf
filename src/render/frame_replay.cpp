// A sample of the frame once more, alone, with the events of its path in words.
#include <algorithm>
#include <cstdio>
#include <tuple>

#include "render/frame_parts.h"
#include "sampling/draw.h"
#include "simd/dispatch.h"
#include "trace/geometry_cache.h"

namespace kinora::render {

// Stages before the first one of camera paths, for all samples of the pass that `sample` belongs to.
bool Frame::replayEarlierStages(int sample, uint32_t& camera) {
  camera = 0;
  while (camera + 1 < stages_.size() && stages_[camera].kind != StageKind::CameraPaths) ++camera;
  if (!store_) return true;
  const int most = passSamplesOf(*in_.integrator, in_.integratorData);
  int first = 0, last = 0;
  for (const auto& [from, to] :
       passes(sample < in_.firstSample ? 0 : in_.firstSample, std::max(in_.lastSample, sample + 1), most))
    if (from <= sample) std::tie(first, last) = std::pair(from, to);
  store_->beginPass();
  for (uint32_t s = 0; s < camera; ++s) {
    store_->beginStage(s);
    const uint64_t paths = pathsOf(stages_[s]);
    for (int k = first; k < last; ++k)
      for (uint64_t from = 0; from < paths; from += in_.groupSize)
        for (WaitingGroup waiting;;) {
          workers_[0]->beginTry();
          lightPaths(*workers_[0], from, uint32_t(std::min<uint64_t>(in_.groupSize, paths - from)), k, s);
          const bool isKept = workers_[0]->keepTry();
          if (trace::GeometryCache::wasCutShort()) return false;
          if (isKept) break;
          if (!readMet(waiting, *workers_[0])) return false;
        }
    endStage(s, first, last);
  }
  store_->beginStage(camera);
  return true;
}

// Lines wait until it is known that the path met nothing unread: else it is followed once more from its beginning.
bool Frame::replay(int x, int y, int sample, const std::function<void(const std::string&)>& print) {
  const auto& res = in_.world->camera().resolution;
  if (x < 0 || y < 0 || x >= res[0] || y >= res[1] || sample < 0) return false;
  setThreadFloatMode();
  if (learned_ && !learnUpTo(sample)) return false;
  for (WaitingGroup waiting;;) {
    std::vector<std::string> lines;
    const Replayed how = replayOnce(x, y, sample, [&](const std::string& line) { lines.push_back(line); });
    if (how == Replayed::Failed || (how == Replayed::Void && !readMet(waiting, *workers_[0]))) return false;
    if (how == Replayed::Void) continue;
    for (const std::string& line : lines) print(line);
    return true;
  }
}

Frame::Replayed Frame::replayOnce(int x, int y, int sample, const std::function<void(const std::string&)>& print) {
  uint32_t stage;
  if (!replayEarlierStages(sample, stage)) return Replayed::Failed;
  Worker& w = *workers_[0];
  w.beginTry();
  w.begin(16, StageKind::CameraPaths);
  shade::GroupState& s = w.state();
  const int x0 = x / kBlock * kBlock, y0 = y / kBlock * kBlock;
  uint32_t n = 0;
  ActivePixels::forEach(ActivePixels::kAll, x0, y0, [&](int u, int v) { addPath(s, u, v, sample, n); });
  s.group().count = s.group().padded = n;
  cameraRays(w, n);
  w.printSlot = uint32_t((y - y0) * kBlock + (x - x0));
  w.print = print;
  functions_->integrate(in_.integratorData, stage, &s.group(), &w.services());
  w.print = {};
  const bool isKept = w.keepTry();
  if (trace::GeometryCache::wasCutShort()) return Replayed::Failed;
  if (!isKept) return Replayed::Void;
  if (in_.sampleFilters) in_.sampleFilters->run(16, s.pixelX(), s.pixelY(), w.records());
  char line[256];
  for (size_t i = 0; i < in_.plan->sources.size(); ++i) {
    const int offset = in_.plan->offsets[i];
    std::string text = "sample " + in_.plan->sources[i] + ":";
    for (int k = 0; k < in_.plan->widths[i]; ++k) {
      std::snprintf(line, sizeof line, " %.9g", w.records()[offset + k][w.printSlot]);
      text += line;
    }
    print(text);
  }
  return Replayed::Done;
}

}  // namespace kinora::render
