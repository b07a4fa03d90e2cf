// The family "core": the loop, against bare Embree, against itself at width 1, and in memory. Each function measures
// one group of figures; core.cpp calls them in turn.
#pragma once
#include <string>

#include "figures.h"
#include "recorded_rays.h"
#include "render/renderer.h"

namespace kinora::bench {

struct Options {
  int repeat = 5;          // repetitions, A and B in turn
  bool quick = false;      // tiny sizes: to test the program, not to measure
  bool full = false;       // with 10 million triangles
  uint32_t groupSize = 0;  // rays a group of "tracing"; 0: the renderer's default
  bool spoil = false;      // one of the values compared is changed: a test of the check
  std::string filter;      // only groups whose name contains this
};

// One thread's pass from the middle of a frame, where groups are full; its rays go to `recorded`.
render::Settings passOfFullGroups(const Options& options, RecordedRays& recorded);  // core_tracing.cpp

// Writes a tiled mip-mapped picture of side x side into the temporary directory; "" when it cannot be written.
std::string makeTexture(int side, bool isHalf);  // core_textures.cpp

void measureTracing(const Options& options, Figures& figures);       // core_tracing.cpp
void measureRich(const Options& options, Figures& figures);          // core_tracing.cpp
void measureCurves(const Options& options, Figures& figures);        // core_curves.cpp
void measureSurface(const Options& options, Figures& figures);       // core_surface.cpp
void measureFrames(const Options& options, Figures& figures);        // core_frames.cpp
void measureLightPaths(const Options& options, Figures& figures);    // core_frames.cpp
void measureLevels(const Options& options, Figures& figures);        // core_levels.cpp
void measureTextures(const Options& options, Figures& figures);      // core_textures.cpp
void measureTextureReads(const Options& options, Figures& figures);  // core_texture_reads.cpp
void measureMemory(const Options& options, Figures& figures);        // core_frames.cpp
void measureLanes(const Options& options, Figures& figures);         // core_frames.cpp
void measureFirstPixel(const Options& options, Figures& figures);    // core_frames.cpp

}  // namespace kinora::bench
