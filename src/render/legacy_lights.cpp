#include "render/legacy_lights.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/text.h"
#include "geometry/tessellate.h"
#include "render/classic_lights.h"

namespace kinora::render {

namespace {

// `to` gets the value that `node` has under `from`.
void rename(scene::Node& out, const scene::Node& node, const char* from, const char* to) {
  if (const scene::Parameter* p = node.params.find(from)) {
    scene::Parameter q = *p;
    q.name = to;
    out.params.set(q);
  }
}

scene::Transform scaled(const scene::Transform& t, double x, double y, double z) {
  scene::Matrix m;
  m.setScale(Imath::V3d(x, y, z));
  return concat(scene::Transform::fixed(m), t);
}

std::shared_ptr<scene::Node> makeNode(const scene::Node& from, const char* plugin) {
  auto n = std::make_shared<scene::Node>();
  n->kind = "Light";
  n->plugin = plugin;
  n->handle = from.handle;
  n->pos = from.pos;
  for (const char* same :
       {"intensity", "exposure", "lightColor", "enableTemperature", "temperature", "coneAngle", "coneSoftness",
        "areaNormalize", "emissionFocus", "emissionFocusTint", "diffuse", "specular", "enableShadows"})
    rename(*n, from, same, same);
  return n;
}

bool isFull(const scene::Quadric& q, size_t sweep) { return std::fabs(q.args[sweep]) >= 359.999f; }

// PxrStdAreaLight and its kin: the geometry says the shape. Geometry of the scene's own emits from its outside; the
// shapes by name (Geometry "rectlight" ...) shone along -Z then. Their power did not grow with their size unless the
// file says so: lights of radius 10 at exposure 8 stand in real files.
bool fromClassic(const scene::Light& l, scene::Light& out) {
  std::string plugin = lowerCase(l.node->plugin);
  // exporters compiled a shader for each of these lights and named it after the object:
  // scene/PxrStdEnvMapLightShape1_rfm
  if (l.node->kind == "AreaLightSource" && plugin.ends_with("_rfm"))
    plugin = plugin.find("envmap") != std::string::npos   ? "pxrstdenvmaplight"
             : plugin.find("envday") != std::string::npos ? "pxrstdenvdaylight"
                                                          : "pxrstdarealight";
  if (plugin != "pxrstdarealight" && plugin != "pxrstdenvmaplight" && plugin != "pxrstdenvdaylight" &&
      plugin != "pxrenvdaylight")
    return false;
  std::string shape = lowerCase(l.node->params.getString("rman__Shape", ""));
  const scene::Quadric* quadric = nullptr;
  bool named = !l.geometry;
  if (l.geometry) {
    quadric = std::get_if<scene::Quadric>(&l.geometry->shape);
    if (const auto* other = std::get_if<scene::OtherPrimitive>(&l.geometry->shape)) {
      named = true;
      if (const scene::Parameter* name = other->args.find("type"); name && !name->strings.empty())
        shape = lowerCase(name->strings[0]);
    }
  }
  out = l;
  // what was said between AreaLightSource and its shape holds for the shape, and the shape is the light
  if (l.geometry) {
    out.toWorld = l.geometry->toWorld;
    if (l.geometry->attributes) out.attributes = l.geometry->attributes;
  }
  out.geometry.reset();
  const auto has = [&](const char* word) { return named && shape.find(word) != std::string::npos; };
  const auto area = [&](const char* modern) {
    std::shared_ptr<scene::Node> n = makeNode(*l.node, modern);
    if (!n->params.find("areaNormalize")) {
      scene::Parameter p;
      p.name = "areaNormalize";
      p.type = scene::ValueType::Int;
      p.ints = {1};
      n->params.set(p);
    }
    out.node = n;
  };
  if (plugin == "pxrstdenvmaplight" || (plugin == "pxrstdarealight" && has("env"))) {
    auto n = makeNode(*l.node, "PxrDomeLight");
    rename(*n, *l.node, "rman__EmissionMap", "lightColorMap");
    rename(*n, *l.node, "rman__EnvMap", "lightColorMap");
    rename(*n, *l.node, "envTint", "lightColor");
    out.node = n;
  } else if (plugin != "pxrstdarealight") {
    auto n = makeNode(*l.node, "PxrEnvDayLight");
    rename(*n, *l.node, "direction", "sunDirection");
    for (const char* same : {"sunDirection", "haziness", "skyTint", "sunTint", "sunSize", "groundMode", "groundColor",
                             "month", "day", "year", "hour", "zone", "latitude", "longitude"})
      rename(*n, *l.node, same, same);
    out.node = n;
  } else if (quadric && quadric->kind == scene::Quadric::Kind::Sphere && isFull(*quadric, 3) &&
             std::fabs(quadric->args[1]) >= 0.999f * std::fabs(quadric->args[0]) &&
             std::fabs(quadric->args[2]) >= 0.999f * std::fabs(quadric->args[0])) {
    area("PxrSphereLight");
    const double r = 2 * quadric->args[0];
    out.toWorld = scaled(out.toWorld, r, r, r);
  } else if (quadric && quadric->kind == scene::Quadric::Kind::Disk && isFull(*quadric, 2) &&
             !geometry::flipsNormals(*l.geometry, false)) {
    area("PxrDiskLight");
    const double r = 2 * quadric->args[1];
    scene::Matrix m;
    m.setScale(Imath::V3d(r, r, 1));
    m[3][2] = quadric->args[0];
    out.toWorld = concat(scene::Transform::fixed(m), out.toWorld);
  } else if (!named) {
    area("PxrMeshLight");
    out.geometry = l.geometry;
  } else if (has("sphere")) {
    area("PxrSphereLight");
  } else if (has("cylinder")) {
    area("PxrCylinderLight");
  } else if (has("distant")) {
    out.node = makeNode(*l.node, "PxrDistantLight");
  } else {
    area(has("disk") ? "PxrDiskLight" : "PxrRectLight");
    out.toWorld = scaled(out.toWorld, 1, 1, -1);
  }
  return true;
}

}  // namespace

bool isAmbient(const scene::Light& light) { return light.node && !light.node->params.getInt("__indirect", 1); }

bool hasStandIn(const scene::Light& light) {
  scene::Light out;
  std::string why;
  return light.node && (fromClassic(light, out) || classicLight(light, false, out, why));
}

const scene::Node* surfaceOf(const scene::Attributes* attributes) {
  if (!attributes || attributes->bxdf) return nullptr;
  for (const scene::NodePtr& n : attributes->classicShaders)
    if (n->kind == "Surface" && !n->plugin.empty()) return n.get();
  return nullptr;
}

// Whether a prototype, or one that it instances, has a light.
static std::vector<bool> prototypesWithLights(const scene::Scene& scene) {
  std::vector<bool> with(scene.prototypes.size());
  for (bool isChanged = true; isChanged;) {
    isChanged = false;
    for (size_t i = 0; i < with.size(); ++i) {
      if (with[i]) continue;
      const scene::Prototype& p = scene.prototypes[i];
      bool holds = !p.lights.empty();
      for (size_t k = 0; k < p.instances.size() && !holds; ++k)
        if (const uint32_t n = p.instances.prototypeOf(k); n < with.size()) holds = with[n];
      with[i] = holds;
      isChanged |= holds;
    }
  }
  return with;
}

// Attributes inside an object, whose coordinate systems stand in its space, as they are in one of its places.
static scene::AttributesPtr placed(const scene::AttributesPtr& attributes, const scene::Transform& toWorld) {
  if (!attributes || !attributes->coordinateSystems) return attributes;
  auto spaces = std::make_shared<std::map<std::string, scene::Transform>>(*attributes->coordinateSystems);
  for (auto& [name, space] : *spaces) space = concat(space, toWorld);
  auto out = std::make_shared<scene::Attributes>(*attributes);
  out->coordinateSystems = std::move(spaces);
  return out;
}

static bool isClassic(const scene::Light& light) { return light.node && light.node->kind != "Light"; }

bool areLightsClassic(const scene::Scene& scene) {
  return scene.lights.empty() && !scene.classicLights.empty() &&
         std::all_of(scene.prototypes.begin(), scene.prototypes.end(),
                     [](const scene::Prototype& p) { return p.lights.empty(); });
}

namespace {

// What stands in for classic lights, each of which is told once, wherever it shines from.
class StandIns {
 public:
  StandIns(bool isPathTraced, Diagnostics& diagnostics) : isPathTraced_(isPathTraced), diagnostics_(diagnostics) {}
  std::optional<scene::Light> of(const scene::Light& l, bool isInObject) {
    std::optional<scene::Light> out(std::in_place);
    std::string why;
    const bool isKnown = fromClassic(l, *out) || classicLight(l, isPathTraced_, *out, why);
    if (isKnown && isInObject && isAmbient(*out)) why = "ambient light has no place that its object could give it";
    if (!isKnown || !why.empty()) out.reset();
    if (!told_.insert(l.node.get()).second) return out;
    if (!out)
      diagnostics_.warning("CLASSIC-LIGHT-OUT", l.node->pos, l.node->kind + " '" + l.node->plugin + "' is left out",
                           why);
    else
      diagnostics_.warning(
          "RENDER-CLASSIC-LIGHT", l.node->pos, l.node->kind + " '" + l.node->plugin + "' is of an old kind",
          out->node->plugin + " stands in" + (out->filters.empty() ? "" : " with BarzelLightFilter"));
    return out;
  }

 private:
  const bool isPathTraced_;
  Diagnostics& diagnostics_;
  std::set<const scene::Node*> told_;
};

}  // namespace

LightsToRender lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics) {
  LightsToRender out;
  std::vector<scene::Light>& all = out.lights;
  all = scene.lights;
  // lights inside prototypes shine from every instance, with the instance's attributes where they have none of their
  // own
  constexpr size_t kMost = 1'000'000;
  const std::vector<bool> holdLights = prototypesWithLights(scene);
  const auto eachWithLights = [&](const scene::InstanceList& list, const auto& visit) {
    for (size_t i = 0; i < list.size(); ++i)
      if (const uint32_t p = list.prototypeOf(i); p < holdLights.size() && holdLights[p]) visit(list[i]);
  };
  StandIns standIns(scene.integrator != nullptr, diagnostics);
  size_t opened = 0;  // without a bound, prototypes that hold the next one twice, level after level, never end
  const auto instantiate = [&](const auto& self, uint32_t prototype, const scene::Transform& toWorld,
                               const scene::AttributesPtr& attributes, int depth) -> void {
    if (depth > 32 || all.size() > kMost || ++opened > all.size() + kMost) return;
    const scene::Prototype& p = scene.prototypes[prototype];
    for (scene::Light l : p.lights) {
      l.toWorld = concat(l.toWorld, toWorld);
      l.attributes = scene::inherit(placed(l.attributes, toWorld), attributes);
      // which side of it shines is the instance's business too
      if (l.geometry) l.geometry->attributes = scene::inherit(l.geometry->attributes, attributes);
      if (!isClassic(l)) {
        all.push_back(std::move(l));
        continue;
      }
      if (l.geometry) l.geometry->toWorld = concat(l.geometry->toWorld, toWorld);
      if (std::optional<scene::Light> standIn = standIns.of(l, true)) all.push_back(std::move(*standIn));
    }
    eachWithLights(p.instances, [&](const scene::Instance& nested) {
      self(self, nested.prototype, concat(nested.toWorld, toWorld),
           scene::inherit(placed(nested.attributes, toWorld), attributes), depth + 1);
    });
  };
  eachWithLights(scene.instances, [&](const scene::Instance& i) {
    instantiate(instantiate, i.prototype, i.toWorld, i.attributes, 0);
  });
  for (const scene::Light& l : scene.classicLights) {
    if (!l.node) continue;
    std::optional<scene::Light> standIn = standIns.of(l, false);
    if (!standIn) continue;
    if (l.geometry) out.shapes.insert(l.geometry->id);
    all.push_back(std::move(*standIn));
  }
  struct Substitute {
    const char *missing, *use;
  };
  static constexpr Substitute kTable[] = {{"pxrstdenvmaplight", "PxrDomeLight"},
                                          {"pxrstdenvdaylight", "PxrEnvDayLight"}};
  for (scene::Light& l : all) {
    if (!l.node) continue;
    Diagnostics quiet([](const std::string&, Severity) {});
    if (registry.find(Kind::Light, l.node->plugin, quiet, l.node->pos)) continue;
    for (const Substitute& s : kTable) {
      if (lowerCase(l.node->plugin) != s.missing) continue;
      auto n = makeNode(*l.node, s.use);
      rename(*n, *l.node, "rman__EnvMap", "lightColorMap");
      rename(*n, *l.node, "skyTint", "lightColor");
      diagnostics.warning("PLUGIN-STAND-IN", l.node->pos,
                          "no light '" + l.node->plugin + "' (node '" + l.node->handle + "')",
                          std::string(s.use) + " stands in");
      l.node = n;
      break;
    }
  }
  out.domes = openPortals(scene, all, diagnostics);
  return out;
}

std::string lightsLeftOut(const scene::Scene& scene, Registry& registry) {
  std::set<std::string> names;
  Diagnostics quiet([](const std::string&, Severity) {});
  const auto addUnknown = [&](const std::vector<scene::Light>& lights) {
    for (const scene::Light& l : lights)
      if (isClassic(l) && !hasStandIn(l)) names.insert(l.node->plugin);
  };
  addUnknown(scene.classicLights);
  for (const scene::Prototype& p : scene.prototypes) addUnknown(p.lights);
  const LightsToRender rendered = lightsToRender(scene, registry, quiet);
  for (const scene::Light& l : rendered.lights)
    if (l.node && !registry.find(Kind::Light, l.node->plugin, quiet, l.node->pos)) names.insert(l.node->plugin);
  std::string list;
  for (const std::string& n : names) list += (list.empty() ? "'" : ", '") + n + "'";
  return list;
}

}  // namespace kinora::render
