#include "film/sources.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace kinora::film {

const std::vector<SourceInfo>& builtInSources() {
  using enum Source;
  using K = SourceKind;
  using T_ = ChannelType;
  static const std::vector<SourceInfo> list{
      {"a", Alpha, K::Mask, 1, T_::Float},
      {"Oi", Opacity, K::Color, 3, T_::Color},
      {"z", Depth, K::Data, 1, T_::Float, Reducer::Min},
      {"zfiltered", FiniteDepth, K::Data, 1, T_::Float},
      {"depth", FiniteDepth, K::Data, 1, T_::Float},
      {"__depth", FiniteDepth, K::Data, 1, T_::Float},
      {"id", Id, K::Id, 1, T_::Int, Reducer::ZMin},
      {"id2", Id2, K::Id, 1, T_::Int, Reducer::ZMin},
      {"cpuTime", CpuTime, K::Seconds, 1, T_::Float, Reducer::Total},
      {"sampleCount", SampleCount, K::Count, 1, T_::Float, Reducer::Total},
      {"albedo", Albedo, K::Color, 3, T_::Color},
      {"P", P, K::Position, 3, T_::Point},
      {"__Pworld", P, K::Position, 3, T_::Point},
      {"Po", Po, K::Position, 3, T_::Point},
      {"PRadius", PRadius, K::Data, 1, T_::Float},
      {"incidentRayRadius", RayRadius, K::Data, 1, T_::Float},
      {"incidentRaySpread", RaySpread, K::Data, 1, T_::Float},
      {"mpSize", MpSize, K::Data, 1, T_::Float},
      {"N", Nn, K::Unit, 3, T_::Normal},
      {"Nn", Nn, K::Unit, 3, T_::Normal},
      {"__Nworld", Nn, K::Unit, 3, T_::Normal},
      {"Ng", Ngn, K::Unit, 3, T_::Normal},
      {"Ngn", Ngn, K::Unit, 3, T_::Normal},
      {"Tn", Tn, K::Unit, 3, T_::Normal},
      {"Vn", Vn, K::Unit, 3, T_::Normal},
      {"VLen", VLen, K::Data, 1, T_::Float},
      {"curvature", Curvature, K::Data, 1, T_::Float},
      {"u", U, K::Data, 1, T_::Float},
      {"v", V, K::Data, 1, T_::Float},
      {"w", W, K::Data, 1, T_::Float},
      {"du", Du, K::Data, 1, T_::Float},
      {"dv", Dv, K::Data, 1, T_::Float},
      {"dw", Dw, K::Data, 1, T_::Float},
      {"dufp", Du, K::Data, 1, T_::Float},
      {"dvfp", Dv, K::Data, 1, T_::Float},
      {"dwfp", Dw, K::Data, 1, T_::Float},
      {"st", St, K::Data, 2, T_::Float},
      {"__st", St, K::Data, 2, T_::Float},
      {"s", S, K::Data, 1, T_::Float},
      {"t", T, K::Data, 1, T_::Float},
      {"dPdu", DPdu, K::Position, 3, T_::Vector},
      {"dPdv", DPdv, K::Position, 3, T_::Vector},
      {"dPdw", DPdw, K::Position, 3, T_::Vector},
      {"dPdtime", DPdtime, K::Position, 3, T_::Vector},
      {"dPcameradtime", DPcameradtime, K::Position, 3, T_::Vector},
      {"motionFore", MotionFore, K::Position, 3, T_::Vector},
      {"motionBack", MotionBack, K::Position, 3, T_::Vector},
      {"time", Time, K::Data, 1, T_::Float},
      {"outsideIOR", OutsideIor, K::Data, 1, T_::Float},
      {"biasR", BiasR, K::Data, 1, T_::Float},
      {"biasT", BiasT, K::Data, 1, T_::Float},
      {"geometryLevel", GeometryLevel, K::Data, 1, T_::Float},
  };
  return list;
}

const SourceInfo* findSource(std::string_view name) {
  for (const SourceInfo& s : builtInSources())
    if (name == s.name) return &s;
  return nullptr;
}

Channel channelOf(const SourceInfo& info, std::string name) {
  Channel c;
  switch (info.kind) {
    case SourceKind::Color:
      c = colorChannel(std::move(name), info.name);
      break;
    case SourceKind::Mask:
      c = floatChannel(std::move(name), info.name);
      break;
    case SourceKind::Unit:
      c = normalChannel(std::move(name), info.name);
      break;
    case SourceKind::Position:
      c = positionChannel(std::move(name), info.name);
      break;
    default:
      c = depthChannel(std::move(name), info.name);
      break;
  }
  c.width = info.width;
  c.type = info.type;
  c.reducer = info.reducer;
  if (info.kind == SourceKind::Seconds) {
    // a sample takes microseconds: steps of 2^-40 s, up to 64 s
    c.stepLog2 = -40;
    c.limit = 64;
  }
  return c;
}

std::string sourceLike(std::string_view name) {
  const std::string wanted = lowerCase(std::string(name));
  for (const SourceInfo& s : builtInSources())
    if (lowerCase(s.name) == wanted) return s.name;
  return {};
}

}  // namespace kinora::film
