#include "render/overrides.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/near_name.h"
#include "base/text.h"
#include "film/display_output.h"
#include "render/legacy_lights.h"
#include "scene/known_names.h"

namespace kinora::render {

namespace {

using Names = std::vector<std::string>;

// Numbers separated by commas or blanks; none where the text is anything else.
std::vector<double> numbersIn(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> numbers;
  const char* at = text.c_str();
  for (;;) {
    while (*at == ' ') ++at;
    if (!*at) return numbers;
    char* end = nullptr;
    numbers.push_back(std::strtod(at, &end));
    if (end == at || (*end && *end != ' ')) return {};
    at = end;
  }
}

// What a declaration wants of a value. Unknown: of options and parameters that nobody declares here.
struct Wanted {
  Type type = Type::Float;
  bool isArray = false, isKnown = false;
};

// VALUE as that; "" or what it should be instead.
std::string parse(const std::string& name, const std::string& value, const Wanted& wanted, scene::Parameter& p) {
  p = {};
  p.name = name;
  const auto asText = [&] {
    p.type = scene::ValueType::String;
    p.strings = {value};
    return "";
  };
  if (wanted.isKnown && wanted.type == Type::String) return asText();
  std::vector<double> numbers = numbersIn(value);
  for (const double x : numbers)
    if (std::isnan(x) || (wanted.isKnown && !(std::fabs(x) <= 3.4e38))) return "a finite number";
  if (!wanted.isKnown) {
    if (numbers.empty()) return asText();
    p.type = numbers.size() == 3 ? scene::ValueType::Color : scene::ValueType::Float;
    p.floats.assign(numbers.begin(), numbers.end());
    return "";
  }
  const bool isInt = wanted.type == Type::Int;
  for (const double x : numbers)
    if (isInt && (x != std::floor(x) || std::fabs(x) > 2147483647.0)) return "a whole number";
  const size_t count = wanted.isArray                        ? numbers.size()
                       : isInt || wanted.type == Type::Float ? 1
                       : wanted.type == Type::Matrix         ? 16
                                                             : 3;
  if (count == 3 && numbers.size() == 1 && !wanted.isArray) numbers.assign(3, numbers[0]);
  if (numbers.empty() || numbers.size() != count) {
    if (wanted.isArray) return "numbers";
    return count > 1 ? std::to_string(count) + " numbers" : isInt ? "a whole number" : "a number";
  }
  p.isArray = wanted.isArray;
  p.arrayLength = int(numbers.size());
  if (isInt) {
    p.type = scene::ValueType::Int;
    p.ints.assign(numbers.begin(), numbers.end());
  } else {
    p.type = numbers.size() == 3 && !wanted.isArray ? scene::ValueType::Color : scene::ValueType::Float;
    p.floats.assign(numbers.begin(), numbers.end());
  }
  return "";
}

scene::NodePtr changed(const scene::NodePtr& node, const scene::Parameter& p) {
  auto copy = std::make_shared<scene::Node>(node ? *node : scene::Node());
  copy->params.set(p);
  return copy;
}

struct Declared {
  std::string name;
  Wanted wanted;
};
using Declarations = std::vector<Declared>;

Names namesOf(const Declarations& list) {
  Names names;
  for (const Declared& d : list) names.push_back(d.name);
  return names;
}
const Declared* find(const Declarations& list, const std::string& name) {
  const auto it = std::find_if(list.begin(), list.end(), [&](const Declared& d) { return d.name == name; });
  return it == list.end() ? nullptr : &*it;
}
void addDeclarations(const Descriptor& d, Declarations& out) {
  for (uint32_t i = 0; i < d.paramCount; ++i)
    if (!(d.params[i].flags & kParamOutput))
      out.push_back({d.params[i].name, {d.params[i].type, (d.params[i].flags & kParamArray) != 0, true}});
}

class Overrides {
 public:
  Overrides(scene::Scene& s, const Settings& settings, Registry& r, Diagnostics& d)
      : scene_(s), settings_(settings), registry_(r), diagnostics_(d) {}

  void apply() {
    if (settings_.resolution[0] > 0) scene_.resolution = settings_.resolution;
    if (settings_.crop[0] >= 0) scene_.cropWindow = settings_.crop;
    if (!settings_.integrator.empty()) setIntegratorPlugin();
    for (const auto& [key, value] : settings_.sets) {
      const size_t dot = key.find('.');
      const std::string kind = key.substr(0, dot), name = dot == std::string::npos ? "" : key.substr(dot + 1);
      if (name.empty())
        refuse("--set '" + key + "=" + value + "' does not say KIND.NAME=VALUE", "");
      else
        set(kind, name, value);
    }
  }

 private:
  void refuse(const std::string& what, const std::string& advice) {
    diagnostics_.error("CLI-SET", {}, what, "nothing is rendered", advice);
  }
  void unknown(const std::string& kind, const std::string& name, const std::string& of, const Declarations& known) {
    const std::string near = didYouMean(name, namesOf(known));
    refuse("--set " + kind + "." + name + ": " + of + (of.starts_with("none") ? " has a" : " has no") +
               " parameter '" + name + "'",
           near.empty() ? "`kinora plugins` lists the parameters of each plug-in" : near);
  }
  // False when the value is not what the declaration wants, which has been said then.
  bool read(const std::string& kind, const std::string& name, const std::string& value, const Wanted& wanted,
            scene::Parameter& p) {
    const std::string instead = parse(name, value, wanted, p);
    if (!instead.empty()) refuse("--set " + kind + "." + name + ": '" + value + "' is not " + instead, "");
    return instead.empty();
  }
  // Parameters that a plug-in declares. A plug-in that is not there is reported later, by whoever needs it.
  bool declarations(Kind kind, const std::string& plugin, Declarations& out) {
    Diagnostics silent([](const std::string&, Severity) {});
    const Descriptor* d = registry_.find(kind, plugin, silent, {});
    if (d) addDeclarations(*d, out);
    return d != nullptr;
  }

  void set(const std::string& kind, const std::string& name, const std::string& value) {
    if (kind == "integrator") return setIntegrator(name, value);
    if (kind == "hider") return setHider(name, value);
    if (kind == "projection") return setProjection(name, value);
    if (kind == "light") return setLights(name, value);
    if (kind == "display") return setDisplays(name, value);
    if (kind == "option") return setOption(name, value);
    const std::string near = didYouMean(kind, {"integrator", "hider", "projection", "option", "light", "display"});
    refuse("--set knows no kind '" + kind + "'",
           near.empty() ? "integrator, hider, projection, option, light or display" : near);
  }

  void setIntegratorPlugin() {
    Diagnostics silent([](const std::string&, Severity) {});
    if (!registry_.find(Kind::Integrator, settings_.integrator, silent, {})) {
      Names names;
      for (const Descriptor* d : registry_.all(Kind::Integrator)) names.emplace_back(d->name);
      const std::string near = didYouMean(settings_.integrator, names);
      return refuse("--integrator: there is no integrator '" + settings_.integrator + "'",
                    near.empty() ? "`kinora plugins` lists them; is its library on the plug-in path?" : near);
    }
    auto n = std::make_shared<scene::Node>();
    n->kind = "Integrator";
    n->plugin = settings_.integrator;
    n->handle = "commandLine";
    scene_.integrator = n;
  }

  void setIntegrator(const std::string& name, const std::string& value) {
    if (!scene_.integrator) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Integrator";
      n->plugin = defaultIntegrator(scene_);
      n->handle = "integrator";
      scene_.integrator = n;
    }
    setNode("integrator", Kind::Integrator, scene_.integrator->plugin, name, value, scene_.integrator);
  }

  // A parameter of the node that stands in the scene.
  void setNode(const std::string& what, Kind kind, const std::string& plugin, const std::string& name,
               const std::string& value, scene::NodePtr& node) {
    Declarations known;
    const bool isThere = declarations(kind, plugin, known);
    const Declared* declared = find(known, name);
    if (isThere && !declared) return unknown(what, name, what + " " + plugin, known);
    scene::Parameter p;
    if (read(what, name, value, declared ? declared->wanted : Wanted{}, p)) node = changed(node, p);
  }

  void setHider(const std::string& name, const std::string& value) {
    constexpr Wanted kInt{Type::Int, false, true}, kFloat{Type::Float, false, true}, kText{Type::String, false, true},
        kFloats{Type::Float, true, true};
    static const Declarations known{{"minsamples", kInt},       {"maxsamples", kInt},        {"incremental", kInt},
                                    {"jitter", kInt},           {"sampleoffset", kInt},      {"darkfalloff", kFloat},
                                    {"samplestride", kInt},     {"samplemotion", kInt},      {"samplemode", kText},
                                    {"pixelfiltermode", kText}, {"integrationmode", kText},  {"aperture", kFloats},
                                    {"dofaspect", kFloat},      {"shutteropening", kFloats}, {"maxTime", kFloat},
                                    {"adaptivemetric", kText},  {"pixelvariance", kFloat}};
    const Declared* declared = find(known, name);
    if (!declared) return unknown("hider", name, "the hider", known);
    scene::Parameter p;
    if (!read("hider", name, value, declared->wanted, p)) return;
    if (!scene_.hider) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Hider";
      n->plugin = "raytrace";
      scene_.hider = n;
    }
    scene_.hider = changed(scene_.hider, p);
  }

  void setProjection(const std::string& name, const std::string& value) {
    if (scene_.cameras.empty()) scene_.cameras.emplace_back();
    scene::NodePtr& projection = scene_.cameras[0].projection;
    std::string plugin = projection ? projection->plugin : "PxrOrthographic";
    if (plugin == "perspective") plugin = "PxrPerspective";
    if (plugin == "orthographic") plugin = "PxrOrthographic";
    if (!projection) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Projection";
      n->plugin = plugin;
      projection = n;
    }
    setNode("projection", Kind::Projection, plugin, name, value, projection);
  }

  // Conditions of the scene and what acts as it is read came before.
  void setOption(const std::string& name, const std::string& value) {
    const std::string group = name.substr(0, name.find(':'));
    const bool isAnyones = group == "user" && name.size() > group.size() + 1;
    bool isKnown = isAnyones, isText = false;
    Names names;
    const auto look = [&](const scene::KnownNames& k) {
      scene::eachName(k.names, [&](std::string_view known, bool isString) {
        names.push_back(std::string(k.group) + ":" + std::string(known));
        if (names.back() != name) return false;
        isText = isString;
        return isKnown = true;
      });
    };
    std::for_each(std::begin(scene::kKnownOptions), std::end(scene::kKnownOptions), look);
    std::for_each(std::begin(scene::kMoreOptions), std::end(scene::kMoreOptions), look);
    if (!isKnown) {
      const std::string near = didYouMean(name, names);
      return refuse("--set option." + name + ": there is no option '" + name + "'",
                    near.empty() ? "options are named GROUP:NAME; those of the group user have any name" : near);
    }
    static constexpr std::string_view kReadBefore[] = {"searchpath:archive", "searchpath:procedural",
                                                       "searchpath:dirmap", "shutter:offset"};
    if (group == "Ri" || std::find(std::begin(kReadBefore), std::end(kReadBefore), name) != std::end(kReadBefore))
      return refuse("--set option." + name + ": this option acts while the scene is read, which is before --set",
                    group == "Ri"           ? "--res and --crop; or a file before the scene that says it"
                    : group == "searchpath" ? "--search-path and --dirmap"
                                            : "a file before the scene that says it");
    scene::Parameter p;
    if (!read("option", name, value, isText ? Wanted{Type::String, false, true} : Wanted{}, p)) return;
    if (!isText && !isAnyones && p.type == scene::ValueType::String)
      return refuse("--set option." + name + ": '" + value + "' is not a number", "");
    if (isAnyones)
      diagnostics_.info("CLI-SET-READ", {},
                        "--set option." + name +
                            ": what the scene asked of this option while it was read (IfBegin) "
                            "had the scene's own value");
    scene_.options.set(p);
  }

  // What a light of an old kind takes: what the scene gives it, and what all of them have. Null: nothing of the name.
  static const Declared* classicParameter(const scene::Node& node, const std::string& name, Declarations& own) {
    const bool isPxr = lowerCase(node.plugin).starts_with("pxr");
    own = {{"intensity", {Type::Float, false, true}},
           {isPxr ? "lightColor" : "lightcolor", {Type::Color, false, true}}};
    if (isPxr) own.push_back({"exposure", {Type::Float, false, true}});
    for (const scene::Parameter& p : node.params) {
      Wanted wanted;
      wanted.isKnown = !p.strings.empty() || p.floats.size() == 1 || p.floats.size() == 3 || p.ints.size() == 1;
      wanted.type = !p.strings.empty()     ? Type::String
                    : !p.ints.empty()      ? Type::Int
                    : p.floats.size() == 3 ? Type::Color
                                           : Type::Float;
      if (!find(own, p.name)) own.push_back({p.name, wanted});
    }
    return find(own, name);
  }

  // All lights, those inside objects and those of old kinds too.
  template <class F>
  void eachLight(F&& visit) {
    for (scene::Light& l : scene_.lights) visit(l, false);
    for (scene::Prototype& p : scene_.prototypes)
      for (scene::Light& l : p.lights) visit(l, l.node && l.node->kind != "Light");
    for (scene::Light& l : scene_.classicLights) visit(l, true);
  }

  // Lights of several kinds may stand in one scene: those that have the parameter take it.
  void setLights(const std::string& name, const std::string& value) {
    Declarations known;
    bool isSet = false, isRefused = false, areThere = false;
    eachLight([&](scene::Light& l, bool isClassic) {
      areThere = true;
      if (!l.node || isRefused) return;
      Declarations own;
      const bool isThere = isClassic || declarations(Kind::Light, l.node->plugin, own);
      const Declared* declared = isClassic ? classicParameter(*l.node, name, own) : find(own, name);
      if (isThere && !declared) {
        known.insert(known.end(), own.begin(), own.end());
        return;
      }
      scene::Parameter p;
      isRefused = !read("light", name, value, declared ? declared->wanted : Wanted{}, p);
      if (isRefused) return;
      l.node = changed(l.node, p);
      isSet = true;
    });
    if (isSet || isRefused) return;
    // lights of archives are known by now, those of programs never
    if (!areThere && waitsForPrograms())
      return refuse(
          "--set light." + name + ": the scene has no lights",
          "lights that a program says are left out; Attribute \"procedural\" \"int immediatesubdivide\" [1] "
          "before it runs it with the scene, lights and all");
    unknown("light", name, areThere ? "none of the scene's lights" : "a scene without lights", known);
  }
  bool waitsForPrograms() const {
    return std::any_of(scene_.primitives.begin(), scene_.primitives.end(), [](const scene::PrimitivePtr& p) {
      const auto* other = std::get_if<scene::OtherPrimitive>(&p->shape);
      return other && other->request.starts_with("Procedural") && other->args.find("around") &&  // it is run later
             other->args.getString("type", "") != "DelayedReadArchive";
    });
  }

  void setDisplays(const std::string& name, const std::string& value) {
    Declarations known;
    for (const Descriptor* d : registry_.all(Kind::Display)) addDeclarations(*d, known);
    for (const std::string& common : film::commonDisplayParameters()) known.push_back({common, {}});
    const Declared* declared = find(known, name);
    if (!declared && !name.starts_with("exrheader_"))
      return unknown("display", name, "none of the display drivers", known);
    scene::Parameter p;
    if (!read("display", name, value, declared ? declared->wanted : Wanted{}, p)) return;
    for (scene::Display& d : scene_.displays) d.params.set(p);
  }

  scene::Scene& scene_;
  const Settings& settings_;
  Registry& registry_;
  Diagnostics& diagnostics_;
};

}  // namespace

void applyOverrides(scene::Scene& scene, const Settings& settings, Registry& registry, Diagnostics& diagnostics) {
  Overrides(scene, settings, registry, diagnostics).apply();
}

namespace {

// Whether surfaces of a material may give off light, by its nodes' parameters.
bool mayGlow(const scene::Network& material) {
  const auto isAbove0 = [](const scene::Parameter* p, bool otherwise) {
    if (!p) return otherwise;
    return p->isReference || std::any_of(p->floats.begin(), p->floats.end(), [](float x) { return x > 0; });
  };
  const auto glows = [&](const scene::NodePtr& n) {
    if (!n) return false;
    const bool isConstant = sameName(n->plugin, "PxrConstant");
    return sameName(n->plugin, "LamaEmission") || isAbove0(n->params.find("emitColor"), isConstant) ||
           isAbove0(n->params.find("glowGain"), false);
  };
  return glows(material.terminal) || std::any_of(material.patterns.begin(), material.patterns.end(), glows);
}

bool mayGlow(const std::vector<scene::PrimitivePtr>& primitives) {
  const scene::Network* last = nullptr;  // those that follow each other have one material
  for (const scene::PrimitivePtr& p : primitives) {
    const scene::Network* m = p->attributes ? p->attributes->bxdf.get() : nullptr;
    if (m && m != last && mayGlow(*m)) return true;
    last = m;
  }
  return false;
}

}  // namespace

const char* defaultIntegrator(const scene::Scene& scene) {
  const auto shine = [](const scene::Light& l) { return (l.node && l.node->kind == "Light") || hasStandIn(l); };
  const bool isDark = scene.lights.empty() &&
                      std::none_of(scene.classicLights.begin(), scene.classicLights.end(), hasStandIn) &&
                      !mayGlow(scene.primitives) &&
                      std::all_of(scene.prototypes.begin(), scene.prototypes.end(), [&](const scene::Prototype& p) {
                        return std::none_of(p.lights.begin(), p.lights.end(), shine) && !mayGlow(p.primitives);
                      });
  return isDark ? "PxrDefault" : "PxrPathTracer";
}

}  // namespace kinora::render
