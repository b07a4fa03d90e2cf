#include "film/display_channels.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "base/text.h"
#include "film/light_paths.h"
#include "film/pixel_filter.h"
#include "film/sources.h"

namespace kinora::film {
namespace {

bool isThreeFloats(scene::ValueType t) {
  return t == scene::ValueType::Color || t == scene::ValueType::Point || t == scene::ValueType::Vector ||
         t == scene::ValueType::Normal;
}

// A channel of the type that the declaration names; nothing when a film cannot hold it.
std::optional<Channel> channelOfType(const scene::DisplayChannel& d, const std::string& source) {
  const int n = std::max(1, d.arrayLength);
  std::optional<Channel> c;
  switch (d.type) {
    case scene::ValueType::Color:
      c = colorChannel(d.name, source);
      break;
    case scene::ValueType::Point:
      c = positionChannel(d.name, source);
      break;
    // vectors may be motion in pixels or derivatives: they need a position's range
    case scene::ValueType::Vector:
      c = positionChannel(d.name, source);
      c->type = ChannelType::Vector;
      break;
    case scene::ValueType::Normal:
      c = normalChannel(d.name, source);
      break;
    case scene::ValueType::HPoint:
      c = positionChannel(d.name, source);
      c->width = 4;
      break;
    case scene::ValueType::Int:
      c = depthChannel(d.name, source);
      c->reducer = Reducer::ZMin;
      c->type = ChannelType::Int;
      c->width = n;
      return n <= 4 ? c : std::nullopt;
    case scene::ValueType::Float:
      // a float of any meaning needs range; masks ("a") are built in
      c = depthChannel(d.name, source);
      c->reducer = Reducer::Sum;
      c->width = n;
      return n <= 4 ? c : std::nullopt;
    default:
      return std::nullopt;
  }
  return n == 1 ? c : std::nullopt;
}

// "color lpe:C<RD>" -> "lpe:C<RD>": the type is that of the channel.
std::string withoutType(const std::string& source) {
  const size_t space = source.find(' ');
  if (space == std::string::npos) return source;
  const std::string first = source.substr(0, space);
  for (const char* t : {"color", "float", "point", "vector", "normal", "int", "integer", "hpoint"})
    if (first == t) {
      const size_t rest = source.find_first_not_of(' ', space);
      return rest == std::string::npos ? source : source.substr(rest);
    }
  return source;
}

std::string typeOf(const scene::DisplayChannel& d) {
  const std::string array = d.arrayLength > 1 ? "[" + std::to_string(d.arrayLength) + "]" : "";
  return scene::nameOf(d.type) + array;
}

class Describer {
 public:
  // hasRule: the channel itself says how it is filtered, not its display.
  Describer(const scene::Scene& scene, const scene::DisplayChannel& d, Diagnostics& diagnostics, bool hasRule)
      : scene_(scene), d_(d), diagnostics_(diagnostics), hasRule_(hasRule) {}

  Channel run() {
    std::string source = withoutType(d_.params.getString("source", d_.name));
    if (source.empty()) source = d_.name;
    Channel c = bySource(source);
    c.name = d_.name;
    // misses have infinite depth: averages read the finite variant
    filterRule(c);
    statistics(c);
    remap(c);
    const bool isExtreme = c.reducer == Reducer::Min || c.reducer == Reducer::Max || c.reducer == Reducer::ZMin ||
                           c.reducer == Reducer::ZMax;
    if (c.source == "z" && !isExtreme) c.source = "zfiltered";
    if (c.isRemapped()) c.source = remappedSource(c.source, c.remap);
    return c;
  }

 private:
  SourcePos posOf(const char* parameter) const {
    const scene::Parameter* p = d_.params.find(parameter);
    return p && p->pos.file ? p->pos : d_.pos;
  }
  void warn(const char* code, const char* parameter, const std::string& what, std::string done,
            std::string advice = {}) {
    diagnostics_.warning(code, posOf(parameter), "channel \"" + d_.name + "\" " + what, std::move(done),
                         std::move(advice));
  }
  void wrongType(const Channel& c, const std::string& done) {
    warn("DISPLAY-CHANNEL-TYPE", "source",
         "is declared as " + typeOf(d_) + ", but its source \"" + c.source + "\" has " + std::to_string(c.width) +
             (c.width == 1 ? " float" : " floats"),
         done);
  }

  Channel bySource(const std::string& source) {
    if (source == "zback") {
      const std::string depth = "z";
      Channel c = channelOf(*findSource(depth), d_.name);
      c.reducer = Reducer::ZMax;
      return checked(std::move(c));
    }
    if (const SourceInfo* known = findSource(source)) return checked(channelOf(*known, d_.name));
    if (LightPaths::knows(source)) return lightPath(source);
    const std::optional<Channel> c = channelOfType(d_, source);
    if (c) {
      if (const std::string like = sourceLike(source); !like.empty())
        warn("DISPLAY-SOURCE", "source", "reads \"" + source + "\", which is no built-in source",
             "it is taken for a primvar", "did you mean \"" + like + "\"?");
      return *c;
    }
    warn("DISPLAY-CHANNEL-TYPE", "source", "has a type that pictures cannot hold (" + typeOf(d_) + ")",
         "it is taken as a colour");
    return colorChannel(d_.name, source);
  }

  // A built-in source keeps its own precision; the declared type decides what kind of three floats it is.
  Channel checked(Channel c) {
    const bool isThree = isThreeFloats(d_.type) && d_.arrayLength <= 1;
    const bool isNumbers = d_.type == scene::ValueType::Float || d_.type == scene::ValueType::Int;
    const bool fits = c.width == 3 ? isThree || (d_.type == scene::ValueType::Float && d_.arrayLength == 3)
                                   : isNumbers && std::max(1, d_.arrayLength) == c.width;
    if (!fits) wrongType(c, "it is written as what the source is");
    return c;
  }

  Channel lightPath(const std::string& source) {
    Channel c = colorChannel(d_.name, source);
    PathSyntaxError error;
    const std::optional<PathExpression> e = LightPaths::parse(source, error);
    if (!e) {
      diagnostics_.warning("LPE-SYNTAX", posOf("source"),
                           "the light path expression of channel \"" + d_.name + "\" is malformed at character " +
                               std::to_string(error.column + 1) + ": " + error.what,
                           "the channel is magenta", caretBelow(source, error.column));
      return colorChannel(d_.name, kVisibleFallback);
    }
    if (e->flags.holdouts)
      warn("LPE-PREFIX", "source", "asks for holdouts alone (\"holdouts;\")", "it holds all surfaces");
    if (e->flags.noClamp && isClamped())
      warn(
          "LPE-PREFIX", "source", "asks for light that no integrator clamped (\"noclamp;\")",
          "the integrator's clamp holds for it too",
          "set clampLuminance of the integrator to 1e30 (of PxrUnified indirectClamp, causticClamp and directClamp)");
    if (isThreeFloats(d_.type) && d_.arrayLength <= 1) {
      // "normal lpe:CU6L": a signal, not a colour
      if (d_.type == scene::ValueType::Normal) return normalChannel(d_.name, source);
      if (d_.type != scene::ValueType::Color) c = positionChannel(d_.name, source);
      return c;
    }
    wrongType(c, "it is taken as a colour");
    return c;
  }

  // Whether the scene's integrator may cut light off, as far as its parameters say: 1e30 is off.
  bool isClamped() const {
    const scene::Node* n = scene_.integrator.get();
    if (!n) return true;
    const auto isOn = [&](const char* name) { return n->params.getFloat(name, 0) < 1e30f; };
    if (sameName(n->plugin, "PxrUnified"))
      return isOn("indirectClamp") || isOn("causticClamp") || isOn("directClamp");
    for (const char* without :
         {"PxrDefault", "PxrDirectLighting", "PxrOcclusion", "PxrValidateBxdf", "PxrVisualizer"})
      if (sameName(n->plugin, without)) return false;
    return isOn("clampLuminance");
  }

  void filterRule(Channel& c) {
    const std::string filter = d_.params.getString("filter", "");
    // depths and ids stay what they are in a display that has a filter
    if (!hasRule_ && c.reducer != Reducer::Sum) return;
    static const std::map<std::string, Reducer> rules{
        {"filter", Reducer::Sum}, {"average", Reducer::Average}, {"min", Reducer::Min},  {"max", Reducer::Max},
        {"zmin", Reducer::ZMin},  {"zmax", Reducer::ZMax},       {"sum", Reducer::Total}};
    if (const auto it = rules.find(filter); it != rules.end()) {
      c.reducer = it->second;
      if (filter != "filter") return;
    }
    const std::vector<float> width = d_.params.getFloats("filterwidth");
    if (c.reducer != Reducer::Sum || (filter.empty() && width.empty())) {
      if (filter.empty() || rules.contains(filter)) return;
      c.reducer = Reducer::Sum;
    }
    ChannelFilter own{scene_.pixelFilter, scene_.pixelFilterWidth[0], scene_.pixelFilterWidth[1]};
    if (!filter.empty() && filter != "filter") own.name = filter;
    if (width.size() >= 2) {
      own.xWidth = width[0];
      own.yWidth = width[1];
    }
    if (own.name == scene_.pixelFilter && own.xWidth == scene_.pixelFilterWidth[0] &&
        own.yWidth == scene_.pixelFilterWidth[1])
      return;
    PixelFilter made;
    if (const image::Status s = PixelFilter::make(own.name, own.xWidth, own.yWidth, made); !s.ok()) {
      warn("DISPLAY-CHANNEL-FILTER", "filter", "has a filter that cannot be used: " + s.what,
           "the frame's pixel filter is used", "rules are filter, average, min, max, zmin, zmax and sum");
      return;
    }
    c.filter = own;
  }

  void statistics(Channel& c) {
    const std::string s = d_.params.getString("statistics", "");
    const bool isSummed = c.reducer == Reducer::Sum || c.reducer == Reducer::Average;
    if (s == "even") {
      c.half = Half::Even;
    } else if (s == "odd") {
      c.half = Half::Odd;
    } else if (s == "variance" || s == "mse") {
      if (isSummed) {
        c.statistic = s == "mse" ? Statistic::MeanVariance : Statistic::Variance;
        return;
      }
      warn("DISPLAY-CHANNEL-STATISTICS", "statistics", "asks for the " + s + " of values that are not averaged",
           "the values are written");
    } else if (!s.empty() && s != "none") {
      warn("DISPLAY-CHANNEL-STATISTICS", "statistics", "asks for statistics \"" + s + "\"", "its mean is written",
           "statistics are none, variance, mse, even and odd");
    }
  }

  void remap(Channel& c) {
    const std::vector<float> r = d_.params.getFloats("remap");
    if (r.empty() || std::all_of(r.begin(), r.end(), [](float x) { return x == 0; })) return;
    const bool isSummed = c.reducer == Reducer::Sum || c.reducer == Reducer::Average;
    if (r.size() == 3 && r[0] >= 0 && r[0] < r[1] && r[1] < r[2] && r[2] < 1e30f && isSummed &&
        c.statistic == Statistic::Value) {
      c.remap = {r[0], r[1], r[2]};
      return;
    }
    warn("DISPLAY-CHANNEL-REMAP", "remap", "has a remap that is not three rising numbers, or is not averaged",
         "its values are not remapped");
  }

  const scene::Scene& scene_;
  const scene::DisplayChannel& d_;
  Diagnostics& diagnostics_;
  bool hasRule_;
};

}  // namespace

Channel describeChannel(const scene::Scene& scene, const ModeChannel& wanted, const scene::Display& display,
                        Diagnostics& diagnostics) {
  const std::string& name = wanted.name;
  const auto declared = std::find_if(scene.channels.rbegin(), scene.channels.rend(),
                                     [&](const scene::DisplayChannel& d) { return d.name == name; });
  scene::DisplayChannel d;
  if (declared != scene.channels.rend()) {
    d = *declared;
  } else {
    d.name = name;
    d.pos = display.pos;
    const SourceInfo* known = findSource(name);
    if (wanted.type) {
      d.type = *wanted.type;
      d.arrayLength = wanted.arrayLength;
    } else if (known) {
      d.type = known->width == 3 ? scene::ValueType::Color : scene::ValueType::Float;
      d.arrayLength = known->width == 3 ? 1 : known->width;
    } else if (name == "zback") {
      d.type = scene::ValueType::Float;
    } else if (!LightPaths::knows(name)) {
      const std::string like = sourceLike(name);
      diagnostics.warning(
          "DISPLAY-CHANNEL", display.pos, "channel \"" + name + "\" is not declared",
          "it is taken as a primvar of that name, a colour",
          like.empty() ? "add DisplayChannel \"color " + name + "\"" : "did you mean \"" + like + "\"?");
      return colorChannel(name);
    }
  }
  // what the display says holds for channels that do not say otherwise
  const bool hasRule = d.params.find("filter") != nullptr;
  for (const char* parameter : {"filter", "filterwidth", "remap"})
    if (const scene::Parameter* p = display.params.find(parameter); p && !d.params.find(parameter)) d.params.set(*p);
  return Describer(scene, d, diagnostics, hasRule).run();
}

}  // namespace kinora::film
