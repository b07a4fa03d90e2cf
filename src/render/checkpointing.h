// What is asked of a frame's checkpoints, by command line and scene; render/checkpoint.h makes them.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

// After so many seconds, or so many passes over the picture; neither: never.
struct CheckpointTime {
  double seconds = 0;
  int passes = 0;
  bool isSet() const { return seconds > 0 || passes > 0; }
  bool isOver(double s, int p) const { return (seconds > 0 && s >= seconds) || (passes > 0 && p >= passes); }
};
// parseTime()'s; "16i" and "-16": passes; "0": never. None where it is none of these.
std::optional<CheckpointTime> parseCheckpointTime(std::string_view text);

// What is asked of a frame.
struct Checkpointing {
  std::string file;              // "": none are written or read
  CheckpointTime every, exitAt;  // exitAt: since the render began; one is written then, and the frame is interrupted
  bool recovers = false;         // goes on from the file, where there is one of this frame
  bool keepsFile = false;        // when the frame is complete
  std::function<void()> wasWritten;  // called after each; null: nothing is
  bool isOn() const { return !file.empty() && (every.isSet() || exitAt.isSet() || recovers); }
};
// Option "checkpoint" of the scene where the command line says nothing; what is wrong with it is told.
Checkpointing checkpointingOf(const scene::Scene& scene, const Checkpointing& commandLine, Diagnostics& diagnostics);

}  // namespace kinora::render
