#include "render/frame_statistics.h"

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

  s.memory.push_back({"film", film.bytes()});
  s.memory.push_back({"group arenas", frame.arenaBytes()});
  if (frame.store()) s.memory.push_back({"records between stages (peak)", frame.store()->mostBytes()});
  if (frame.learned()) s.memory.push_back({"learned by paths (peak)", frame.learned()->mostBytes()});
  s.memory.push_back({"texture cache", t.cacheBytes + t.imageBytes});
  s.memory.push_back({"process (resident)", Memory::resident()});
}

}  // namespace kinora::render
