#include "render/frame_statistics.h"

#include <algorithm>

#include "base/memory.h"
#include "texture/texture_system.h"

namespace kinora::render {

void addFrame(const Frame& frame, const film::Film& film, WorldBuilder& builder, Statistics& statistics) {
  Statistics& s = statistics;
  frame.addTo(s);
  const film::FilmCounters counters = film.counters();
  s.nonFiniteSamples = counters.nonFinite;
  s.negativeSamples = counters.negative;
  for (const uint64_t n : counters.saturated) s.saturatedSamples += n;
  builder.countLevels(s);
  builder.countVolumes(s);

  const TextureStatistics t = builder.textures().statistics();
  s.textureLookups = t.lookups;
  s.textureMisses = t.cacheMisses;
  s.textureBytes = t.cacheBytes;
  s.textureTilesAgain = t.tilesAgain;
  s.textureBytesRead = t.bytesRead;
  s.largestTextures.clear();
  for (const auto& file : t.largest) s.largestTextures.push_back({file.path, file.bytesRead, file.tilesAgain});

  const auto own = [&](const char* name, uint64_t bytes) {
    const auto known = std::find_if(s.memory.begin(), s.memory.end(), [&](const auto& o) { return o.name == name; });
    if (known != s.memory.end())
      known->bytes = bytes;
    else
      s.memory.push_back({name, bytes});
  };
  own("film", film.bytes());
  own("group arenas", frame.arenaBytes());
  if (frame.store()) own("records between stages (peak)", frame.store()->mostBytes());
  if (frame.learned()) own("learned by paths (peak)", frame.learned()->mostBytes());
  own("texture cache", t.cacheBytes + t.imageBytes);
  if (s.geometry.made) own("geometry cache", s.geometry.bytes);
  // What the process holds beyond: the program's own data, buffers of libraries, freed memory that the allocator keeps.
  own(Statistics::kOthers, 0);
  uint64_t counted = 0;
  for (const Statistics::Owner& o : s.memory) counted += o.bytes;
  const uint64_t resident = Memory::resident();
  own(Statistics::kOthers, resident > counted ? resident - counted : 0);
}

}  // namespace kinora::render
