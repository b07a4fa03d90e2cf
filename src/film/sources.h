// The built-in sources of display channels: what each is named, what it holds and how it is summed where a
// declaration does not say. The one list: display_channels.cpp makes channels from it, render/ fills them at the
// surface that the camera sees. Light path expressions are sources too (light_paths.h), and any other name is a
// primvar's.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "film/channel.h"

namespace kinora::film {

enum class Source : uint8_t {
  LightPath,  // Ci, beauty, and all that LightPaths::knows
  Primvar,    // none of the built-in ones
  Fallback,   // a malformed expression: magenta
  Alpha,
  Opacity,      // 1 where something is hit
  Depth,        // along the camera's axis; infinite where nothing is hit
  FiniteDepth,  // the same, 0 where nothing is hit: what averages read
  Id,
  Id2,
  CpuTime,
  SampleCount,
  Albedo,
  P,
  Po,  // world space; object space
  PRadius,
  RayRadius,
  RaySpread,
  MpSize,  // footprint of the path at P: radius, growth per distance, diameter
  Nn,
  Ngn,
  Tn,
  Vn,
  VLen,
  Curvature,
  U,
  V,
  W,
  Du,
  Dv,
  Dw,
  St,
  S,
  T,
  DPdu,
  DPdv,
  DPdw,
  DPdtime,
  DPcameradtime,
  MotionFore,
  MotionBack,
  Time,
  OutsideIor,
  BiasR,
  BiasT,
  GeometryLevel  // by how many powers of two coarser than the camera asks the surface was diced
};

// How a value is rounded and written.
enum class SourceKind : uint8_t { Color, Mask, Data, Position, Unit, Id, Count, Seconds };

struct SourceInfo {
  const char* name;
  Source source;
  SourceKind kind;
  int width;
  ChannelType type;
  Reducer reducer = Reducer::Sum;
};

// By name; case matters. Null: not built in (see LightPaths::knows).
const SourceInfo* findSource(std::string_view name);
const std::vector<SourceInfo>& builtInSources();
// A channel named `name` that reads the source as the list says.
Channel channelOf(const SourceInfo& info, std::string name);
// The name in the list that differs by case alone, for messages; "" when there is none.
std::string sourceLike(std::string_view name);

}  // namespace kinora::film
