// Part of a frame's samples as a file: the integers of a Film in an EXR, with what is needed to know which parts
// belong together and to write the picture at the end. Written by `kinora render --samples` and as checkpoint of a frame,
// read by `kinora merge` and `kinora render --recover`. It never rounds: merged parts equal the unsplit film bit for bit.
// Everything read is checked before it is believed; a broken or hostile file gives a Status.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/file_contents.h"
#include "film/film.h"
#include "scene/identity.h"

namespace kinora::film {

// Sample indices begin <= i < end of every pixel.
struct SampleRange {
  uint32_t begin = 0, end = 0;
  bool operator==(const SampleRange&) const = default;
};

struct ShardInfo {
  static constexpr int kVersion = 4;
  std::string sceneHash;  // of everything that decides a pixel but seed and sample range
  // What the hash was made of, to name a difference by; it decides nothing.
  scene::Inventory inventory;
  // Files that were met while the samples were taken: where two parts met one, it held the same.
  std::vector<FileContents::Entry> lateFiles;
  uint64_t seed = 0;
  int frame = 0;
  std::string pixelFilter;          // for messages; part of the scene hash
  std::vector<SampleRange> ranges;  // sorted, disjoint
  double renderSeconds = 0;         // sum over the parts
  std::string kinoraVersion;
  std::string outputs;  // display_output.h's description of the displays, as JSON; not looked into here
  // Of a checkpoint: what the render that wrote it needs to go on, beside the sums. Bytes that are not looked into here;
  // merged parts have none.
  std::string progress;
};

struct Shard {
  ShardInfo info;
  std::unique_ptr<Film> film;
};

// Atomic; FILM-SHARD-WRITE or IMAGE-WRITE on failure.
Status writeShard(const std::string& path, const Film& film, const ShardInfo& info);
// `maxBytes` bounds the memory a file may ask for.
Status readShard(const std::string& path, Shard& out, uint64_t maxBytes = uint64_t(1) << 36);
// True when the file is an EXR that says it is a shard. Reads the header only.
bool isShard(const std::string& path);

// Whether both are of one frame: scene hash, seed, frame number, files; the reason in the status where they are not.
Status isOfOneFrame(const ShardInfo& before, const ShardInfo& part);
// Adds `part` to `sum` when both are parts of one frame (scene hash, seed, frame, layout, window) and no sample is in
// both. Nothing is changed on failure.
Status addShard(Shard& sum, const Shard& part);
// Reads and adds all; gaps between the ranges (or a first sample other than 0) become warnings.
Status mergeShards(const std::vector<std::string>& paths, Shard& out, std::vector<std::string>& warnings,
                   uint64_t maxBytes = uint64_t(1) << 36);

}  // namespace kinora::film
