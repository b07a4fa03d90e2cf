// Reads RIB (ASCII, binary, gzip) into scene descriptions. Called by app/ (render, info, rib) and by tests. Several
// files are one stream: graphics state carries over. A mistake in a file is reported and repaired as the message
// says; reading goes on. It runs no program that a scene names unless it is told to, loads no plug-in, and has no
// opinion on what can be rendered.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/explain.h"
#include "scene/procedural.h"
#include "scene/scene.h"

namespace kinora::rib {

struct ReadOptions {
  std::vector<std::string> archivePath;  // asked after the scene's own search path; also what '@' stands for there
  std::vector<std::pair<std::string, std::string>> dirmap;  // FROM, TO: replaced at the start of all paths
  const std::atomic<bool>* stop = nullptr;                  // set: reading ends as if the file ended
  bool checkOnly = false;         // primitives are checked and let go: a file larger than memory can be checked
  int maxArchiveDepth = 64;       // archives in archives
  int maxArchiveReads = 1000000;  // in all: archives that multiply end here
  int maxBlockDepth = 10000;      // open blocks
  bool allowExec = false;         // programs that the scene names are run for what they print
  std::string proceduralHost;  // the program that runs shared objects of DynamicLoad (ri/); empty: they are not run
  double programSeconds = 60;  // each at most so long
  // Procedurals with a finite bound are not read: they are primitives that stand for what procedurals() can read.
  bool delaysProcedurals = false;
};

class RibReader {
 public:
  using OnWorld = std::function<void(scene::Scene&&)>;  // at each WorldEnd
  RibReader(Diagnostics& messages, ReadOptions options, OnWorld onWorld);
  ~RibReader();
  RibReader(const RibReader&) = delete;

  // Each returns false when nothing could be read at all: missing, a directory, empty. "-" is standard input.
  bool readFile(const std::string& path);
  bool readString(const std::string& name, std::string text);
  // Closes what is still open (with a message) and says when no world was met. Call once, after the last file.
  void finish();

  uint64_t bytesRead() const;  // after decompression, archives included
  size_t worlds() const;       // handed to onWorld
  // Of the world that is, or was last, handed to onWorld; null: it delays none.
  std::shared_ptr<const scene::ProceduralSources> procedurals() const;

 private:
  std::unique_ptr<class Interpreter> interpreter_;
};

// Every message code of this room with its long form, for `kinora explain`.
std::span<const Explanation> explanations();

}  // namespace kinora::rib
