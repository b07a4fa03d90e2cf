#include "film/display_channels.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace kinora::film {
namespace {

Channel dataFloat(std::string name, Reducer reducer = Reducer::Sum, std::string source = {}) {
  Channel c = depthChannel(std::move(name), std::move(source));
  c.reducer = reducer;
  return c;
}
Channel identifier(std::string name) {
  Channel c = dataFloat(std::move(name), Reducer::ZMin);
  c.type = ChannelType::Int;
  return c;
}
Channel vectorOf(std::string name, ChannelType type) {
  Channel c = positionChannel(std::move(name));
  c.type = type;
  return c;
}

// The sources that every integrator has, with the reducer that makes sense of them.
std::optional<Channel> builtIn(const std::string& name) {
  if (name == "Ci" || name == "Oi" || name == "albedo") return colorChannel(name);
  if (name == "a") return floatChannel(name);
  if (name == "z") return dataFloat(name, Reducer::Min);
  if (name == "zback") return dataFloat(name, Reducer::ZMax, "z");
  if (name == "id" || name == "id2") return identifier(name);
  if (name == "P") return positionChannel(name);
  if (name == "cpuTime" || name == "sampleCount") return dataFloat(name, Reducer::Total);
  for (const char* n : {"Nn", "Ngn", "Tn", "Vn"})
    if (name == n) return normalChannel(name);
  for (const char* n : {"dPdu", "dPdv", "dPdw", "dPdtime", "dPcameradtime", "motionFore", "motionBack"})
    if (name == n) return vectorOf(name, ChannelType::Vector);
  for (const char* n : {"__Pworld", "__Pref", "__WPref"})
    if (name == n) return vectorOf(name, ChannelType::Point);
  for (const char* n : {"__Nworld", "__Nref", "__WNref"})
    if (name == n) return normalChannel(name);
  for (const char* n : {"zfiltered",
                        "PRadius",
                        "VLen",
                        "curvature",
                        "incidentRaySpread",
                        "incidentRayRadius",
                        "mpSize",
                        "u",
                        "v",
                        "w",
                        "du",
                        "dv",
                        "dw",
                        "dufp",
                        "dvfp",
                        "dwfp",
                        "time",
                        "outsideIOR",
                        "biasR",
                        "biasT",
                        "__depth"})
    if (name == n) return dataFloat(name);
  return std::nullopt;
}

// The type that the declaration names; false when a film cannot hold it.
bool applyType(const scene::DisplayChannel& d, Channel& c) {
  const int n = std::max(1, d.arrayLength);
  switch (d.type) {
    case scene::ValueType::Color:
      c = colorChannel(c.name, c.source);
      return n == 1;
    case scene::ValueType::Point:
      c = positionChannel(c.name, c.source);
      return n == 1;
    case scene::ValueType::Vector:
    case scene::ValueType::Normal: {
      // vectors may be motion in pixels or derivatives: they need a position's range
      const bool isUnit = d.type == scene::ValueType::Normal;
      c = isUnit ? normalChannel(c.name, c.source) : positionChannel(c.name, c.source);
      if (!isUnit) c.type = ChannelType::Vector;
      return n == 1;
    }
    case scene::ValueType::HPoint:
      c = positionChannel(c.name, c.source);
      c.width = 4;
      return n == 1;
    case scene::ValueType::Int: {
      const std::string source = c.source;
      c = identifier(c.name);
      c.source = source;
      c.width = n;
      return n <= 4;
    }
    case scene::ValueType::Float: {
      // "a" and masks are averaged like colours; a float of any other meaning needs range
      const bool isMask = c.source == "a";
      const std::string source = c.source;
      c = isMask ? floatChannel(c.name, source) : dataFloat(c.name, Reducer::Sum, source);
      c.width = n;
      return n <= 4;
    }
    default:
      return false;
  }
}

// "color lpe:C<RD>" -> "lpe:C<RD>": the type is that of the channel.
std::string withoutType(const std::string& source) {
  const size_t space = source.find(' ');
  if (space == std::string::npos) return source;
  const std::string first = source.substr(0, space);
  for (const char* t : {"color", "float", "point", "vector", "normal", "int", "integer", "hpoint"})
    if (first == t)
      return source.substr(
          source.find_first_not_of(' ', space) == std::string::npos ? space : source.find_first_not_of(' ', space));
  return source;
}

void applyFilter(const scene::DisplayChannel& d, Channel& c, Diagnostics& diagnostics) {
  const std::string filter = d.params.getString("filter", "");
  static const std::map<std::string, Reducer> table{
      {"filter", Reducer::Sum}, {"average", Reducer::Average}, {"min", Reducer::Min},  {"max", Reducer::Max},
      {"zmin", Reducer::ZMin},  {"zmax", Reducer::ZMax},       {"sum", Reducer::Total}};
  if (const auto it = table.find(filter); it != table.end()) {
    c.reducer = it->second;
  } else if (!filter.empty()) {
    c.reducer = Reducer::Sum;  // the name of a pixel filter: one filter serves the whole frame
    diagnostics.warning("DISPLAY-CHANNEL-FILTER", d.pos,
                        "channel \"" + d.name + "\" asks for a pixel filter of its own (\"" + filter + "\")",
                        "the frame's pixel filter is used");
  }
  const std::string statistics = d.params.getString("statistics", "");
  if (statistics == "even")
    c.half = Half::Even;
  else if (statistics == "odd")
    c.half = Half::Odd;
  else if (!statistics.empty() && statistics != "none")
    diagnostics.warning("DISPLAY-CHANNEL-STATISTICS", d.pos,
                        "channel \"" + d.name + "\" asks for statistics \"" + statistics + "\"",
                        "its mean is written", "use \"even\" and \"odd\", whose difference gives the error");
}

}  // namespace

Channel describeChannel(const scene::Scene& scene, const std::string& name, const SourcePos& usedAt,
                        Diagnostics& diagnostics) {
  const std::optional<Channel> known = builtIn(name);
  const auto declared = std::find_if(scene.channels.rbegin(), scene.channels.rend(),
                                     [&](const scene::DisplayChannel& d) { return d.name == name; });
  if (declared == scene.channels.rend()) {
    if (!known)
      diagnostics.warning("DISPLAY-CHANNEL", usedAt, "channel \"" + name + "\" is not declared",
                          "it is taken as a colour", "add DisplayChannel \"color " + name + "\"");
    Channel c = known ? *known : colorChannel(name);
    return c;
  }
  const scene::DisplayChannel& d = *declared;
  Channel c;
  c.name = name;
  c.source = withoutType(d.params.getString("source", name));
  if (c.source.empty()) c.source = name;
  const std::optional<Channel> source = builtIn(c.source);
  if (!applyType(d, c)) {
    diagnostics.warning("DISPLAY-CHANNEL-TYPE", d.pos,
                        "channel \"" + name + "\" has a type that pictures cannot hold", "it is taken as a colour");
    const std::string from = c.source;
    c = colorChannel(name, from);
  }
  // a declaration of a known source keeps its precision and reducer unless it says otherwise
  if (source && source->width == c.width) {
    const std::string from = source->source;
    c = *source;
    c.name = name;
    c.source = from;
  }
  applyFilter(d, c, diagnostics);
  // misses have infinite depth: averages read the finite variant
  const bool isExtreme = c.reducer == Reducer::Min || c.reducer == Reducer::Max || c.reducer == Reducer::ZMin ||
                         c.reducer == Reducer::ZMax;
  if (c.source == "z" && !isExtreme) c.source = "zfiltered";
  return c;
}

}  // namespace kinora::film
