#include "render/legacy_lights.h"

#include <cmath>

#include "base/text.h"
#include "geometry/tessellate.h"

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

// Lights of the shading-language age by the kind that their name tells, as RISpec's appendix A.2 defines them. Such
// lights met surfaces without the 1 / pi of a Lambert surface: a point light of intensity I gives irradiance pi I /
// d^2 here. Distances are those of the world, whatever scale the light was declared under: its shader computed with
// the vector from the light to the surface in world space. Ambient light has no direction: nothing shadows it, and no
// mirror or highlight shows it. It is all that arrives by way of other surfaces, so that what these send on of it
// does not count again.
bool fromShader(const scene::Light& l, scene::Light& out) {
  if (l.node->kind != "LightSource") return false;
  const std::string name = lowerCase(l.node->plugin);
  const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
  const scene::ParameterList& given = l.node->params;
  const auto point = [&](const char* parameter, Imath::V3d fallback) {
    const std::vector<float> v = given.getFloats(parameter);
    return v.size() >= 3 ? Imath::V3d(v[0], v[1], v[2]) : fallback;
  };
  const double intensity = given.getFloat("intensity", 1);
  const Imath::V3d from = point("from", {0, 0, 0}), to = point("to", {0, 0, 1});
  Imath::V3d axis = (to - from).length() > 0 ? (to - from).normalized() : Imath::V3d(0, 0, 1);
  const auto n = std::make_shared<scene::Node>();
  n->kind = "Light";
  n->handle = l.node->handle;
  n->pos = l.node->pos;
  const auto number = [&](const char* parameter, double value) {
    scene::Parameter p;
    p.name = parameter;
    p.floats = {float(value)};
    n->params.set(p);
  };
  const auto off = [&](const char* parameter) {
    scene::Parameter p;
    p.name = parameter;
    p.type = scene::ValueType::Int;
    p.ints = {0};
    n->params.set(p);
  };
  rename(*n, *l.node, "lightcolor", "lightColor");
  out = l;
  // local +Z along the light's axis
  const Imath::V3d side =
      (std::fabs(axis.x) < 0.9 ? Imath::V3d(1, 0, 0) : Imath::V3d(0, 1, 0)).cross(axis).normalized();
  const Imath::V3d up = axis.cross(side);
  scene::Matrix m(side.x, side.y, side.z, 0, up.x, up.y, up.z, 0, axis.x, axis.y, axis.z, 0, from.x, from.y, from.z,
                  1);
  constexpr double kPi = 3.14159265358979;
  const bool isAmbient = has("ambient");
  if (isAmbient) {
    n->plugin = "PxrDomeLight";
    number("intensity", intensity);
    off("enableShadows");
    off("__indirect");
    number("specular", 0);
  } else if (has("distant") || has("solar")) {
    n->plugin = "PxrDistantLight";
    number("angleExtent", 0);
    number("intensity", kPi * intensity);
  } else if (has("point") || has("spot")) {
    n->plugin = "PointLight";
    number("intensity", kPi * intensity);
    if (has("spot")) {
      number("coneAngle", given.getFloat("coneangle", 0.5235988f) * (180 / kPi));
      number("coneDeltaAngle", given.getFloat("conedeltaangle", 0.0872665f) * (180 / kPi));
      number("beamDistribution", given.getFloat("beamdistribution", 2));
    }
  } else {
    return false;
  }
  out.node = n;
  out.toWorld = isAmbient ? scene::Transform() : concat(scene::Transform::fixed(m), l.toWorld);
  auto unseen =
      l.attributes ? std::make_shared<scene::Attributes>(*l.attributes) : std::make_shared<scene::Attributes>();
  scene::Parameter p;
  p.name = "visibility:camera";
  p.type = scene::ValueType::Int;
  p.ints = {0};
  unseen->named.set(p);
  out.attributes = unseen;
  return true;
}

}  // namespace

// Whether a prototype, or one that it instances, has a light.
static std::vector<bool> prototypesWithLights(const scene::Scene& scene) {
  std::vector<bool> with(scene.prototypes.size());
  for (bool isChanged = true; isChanged;) {
    isChanged = false;
    for (size_t i = 0; i < with.size(); ++i) {
      if (with[i]) continue;
      const scene::Prototype& p = scene.prototypes[i];
      bool holds = !p.lights.empty();
      for (const scene::Instance& n : p.instances) holds |= n.prototype < with.size() && with[n.prototype];
      with[i] = holds;
      isChanged |= holds;
    }
  }
  return with;
}

std::vector<scene::Light> lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics,
                                         std::set<uint32_t>& shapes) {
  std::vector<scene::Light> all = scene.lights;
  // lights inside prototypes shine from every instance, with the instance's attributes where they have none of their
  // own
  constexpr size_t kMost = 1'000'000;
  const std::vector<bool> holdLights = prototypesWithLights(scene);
  size_t opened = 0;  // without a bound, prototypes that hold the next one twice, level after level, never end
  const auto instantiate = [&](const auto& self, const scene::Instance& inst, const scene::Transform& toWorld,
                               const scene::AttributesPtr& attributes, int depth) -> void {
    if (inst.prototype >= scene.prototypes.size() || !holdLights[inst.prototype] || depth > 32 ||
        all.size() > kMost || ++opened > all.size() + kMost)
      return;
    const scene::Prototype& p = scene.prototypes[inst.prototype];
    for (scene::Light l : p.lights) {
      l.toWorld = concat(l.toWorld, toWorld);
      l.attributes = scene::inherit(l.attributes, attributes);
      all.push_back(std::move(l));
    }
    for (const scene::Instance& nested : p.instances)
      self(self, nested, concat(nested.toWorld, toWorld), scene::inherit(nested.attributes, attributes), depth + 1);
  };
  for (const scene::Instance& i : scene.instances) instantiate(instantiate, i, i.toWorld, i.attributes, 0);
  for (const scene::Light& l : scene.classicLights) {
    scene::Light out;
    if (!l.node) continue;
    if (!fromClassic(l, out) && !fromShader(l, out)) {
      diagnostics.warning("RENDER-CLASSIC-LIGHT", l.node->pos,
                          l.node->kind + " '" + l.node->plugin + "' is of an old kind, and nothing is known of it",
                          "it is left out", "lights are known by ambient, distant, point or spot in their names");
      continue;
    }
    if (l.geometry) shapes.insert(l.geometry->id);
    diagnostics.warning("RENDER-CLASSIC-LIGHT", l.node->pos,
                        l.node->kind + " '" + l.node->plugin + "' is of an old kind",
                        out.node->plugin + " stands in");
    all.push_back(std::move(out));
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
  return all;
}

}  // namespace kinora::render
