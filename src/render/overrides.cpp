#include "render/overrides.h"

#include <algorithm>
#include <cstdlib>

#include "base/near_name.h"
#include "film/display_output.h"

namespace kinora::render {

namespace {

using Names = std::vector<std::string>;

// VALUE: numbers separated by commas, else text.
scene::Parameter parameterOf(const std::string& name, const std::string& value) {
  scene::Parameter p;
  p.name = name;
  std::string text = value;
  for (char& c : text)
    if (c == ',') c = ' ';
  const char* at = text.c_str();
  for (;;) {
    while (*at == ' ') ++at;
    if (!*at) break;
    char* end = nullptr;
    const float f = std::strtof(at, &end);
    if (end == at) {
      p.floats.clear();
      break;
    }
    p.floats.push_back(f);
    at = end;
  }
  if (p.floats.empty()) {
    p.type = scene::ValueType::String;
    p.strings = {value};
  } else {
    p.type = p.floats.size() == 3 ? scene::ValueType::Color : scene::ValueType::Float;
  }
  return p;
}

scene::NodePtr changed(const scene::NodePtr& node, const scene::Parameter& p) {
  auto copy = std::make_shared<scene::Node>(node ? *node : scene::Node());
  copy->params.set(p);
  return copy;
}

bool holds(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

class Overrides {
 public:
  Overrides(scene::Scene& s, const Settings& settings, Registry& r, Diagnostics& d)
      : scene_(s), settings_(settings), registry_(r), diagnostics_(d) {}

  void apply() {
    if (!settings_.integrator.empty()) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Integrator";
      n->plugin = settings_.integrator;
      n->handle = "commandLine";
      scene_.integrator = n;
    }
    for (const auto& [key, value] : settings_.sets) {
      const size_t dot = key.find('.');
      const std::string kind = key.substr(0, dot), name = dot == std::string::npos ? "" : key.substr(dot + 1);
      if (name.empty())
        refuse("--set '" + key + "=" + value + "' does not say KIND.NAME=VALUE", "");
      else
        set(kind, parameterOf(name, value));
    }
  }

 private:
  void refuse(const std::string& what, const std::string& advice) {
    diagnostics_.error("CLI-SET", {}, what, "nothing is rendered", advice);
  }
  void unknown(const std::string& kind, const std::string& name, const std::string& of, const Names& names) {
    const std::string near = didYouMean(name, names);
    refuse("--set " + kind + "." + name + ": " + of + (of.starts_with("none") ? " has a" : " has no") +
               " parameter '" + name + "'",
           near.empty() ? "`kinora plugins` lists the parameters of each plug-in" : near);
  }
  // Parameters that a plug-in declares. A plug-in that is not there is reported later, by whoever needs it.
  bool names(Kind kind, const std::string& plugin, Names& out) {
    Diagnostics silent([](const std::string&, Severity) {});
    const Descriptor* d = registry_.find(kind, plugin, silent, {});
    for (uint32_t i = 0; d && i < d->paramCount; ++i) out.emplace_back(d->params[i].name);
    return d != nullptr;
  }

  void set(const std::string& kind, const scene::Parameter& p) {
    if (kind == "integrator") return setIntegrator(p);
    if (kind == "hider") return setHider(p);
    if (kind == "projection") return setProjection(p);
    if (kind == "option") return scene_.options.set(p), void();
    if (kind == "light") return setLights(p);
    if (kind == "display") return setDisplays(p);
    const std::string near = didYouMean(kind, {"integrator", "hider", "projection", "option", "light", "display"});
    refuse("--set knows no kind '" + kind + "'",
           near.empty() ? "integrator, hider, projection, option, light or display" : near);
  }

  void setIntegrator(const scene::Parameter& p) {
    if (!scene_.integrator) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Integrator";
      n->plugin = defaultIntegrator(scene_);
      n->handle = "integrator";
      scene_.integrator = n;
    }
    Names known;
    if (names(Kind::Integrator, scene_.integrator->plugin, known) && !holds(known, p.name))
      return unknown("integrator", p.name, "integrator " + scene_.integrator->plugin, known);
    scene_.integrator = changed(scene_.integrator, p);
  }

  void setHider(const scene::Parameter& p) {
    static const Names known{"minsamples",  "maxsamples",     "incremental",     "jitter",          "sampleoffset",
                             "darkfalloff", "samplemode",     "pixelfiltermode", "integrationmode", "aperture",
                             "dofaspect",   "shutteropening", "maxTime",         "adaptivemetric",  "pixelvariance"};
    if (!holds(known, p.name)) return unknown("hider", p.name, "the hider", known);
    scene_.hider = changed(scene_.hider, p);
  }

  void setProjection(const scene::Parameter& p) {
    if (scene_.cameras.empty()) scene_.cameras.emplace_back();
    scene::NodePtr& projection = scene_.cameras[0].projection;
    std::string plugin = projection ? projection->plugin : "PxrOrthographic";
    if (plugin == "perspective") plugin = "PxrPerspective";
    if (plugin == "orthographic") plugin = "PxrOrthographic";
    Names known;
    if (names(Kind::Projection, plugin, known) && !holds(known, p.name))
      return unknown("projection", p.name, "projection " + plugin, known);
    if (!projection) {
      auto n = std::make_shared<scene::Node>();
      n->kind = "Projection";
      n->plugin = plugin;
      projection = n;
    }
    projection = changed(projection, p);
  }

  // Lights of several kinds may stand in one scene: those that have the parameter take it.
  void setLights(const scene::Parameter& p) {
    Names known;
    bool isSet = false;
    for (scene::Light& l : scene_.lights) {
      Names own;
      if (!l.node || (names(Kind::Light, l.node->plugin, own) && !holds(own, p.name))) {
        known.insert(known.end(), own.begin(), own.end());
        continue;
      }
      l.node = changed(l.node, p);
      isSet = true;
    }
    if (!isSet)
      unknown("light", p.name, scene_.lights.empty() ? "a scene without lights" : "none of the scene's lights",
              known);
  }

  void setDisplays(const scene::Parameter& p) {
    Names known = film::commonDisplayParameters();
    for (const Descriptor* d : registry_.all(Kind::Display))
      for (uint32_t i = 0; i < d->paramCount; ++i) known.emplace_back(d->params[i].name);
    if (!holds(known, p.name) && !p.name.starts_with("exrheader_"))
      return unknown("display", p.name, "none of the display drivers", known);
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

const char* defaultIntegrator(const scene::Scene& scene) {
  const bool isDark = scene.lights.empty() && scene.classicLights.empty() &&
                      std::all_of(scene.prototypes.begin(), scene.prototypes.end(),
                                  [](const scene::Prototype& p) { return p.lights.empty(); });
  return isDark ? "PxrDefault" : "PxrPathTracer";
}

}  // namespace kinora::render
