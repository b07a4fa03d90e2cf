#include "render/stand_ins.h"

#include <cctype>
#include <cmath>

namespace kinora::render {

namespace {

std::string lowerCase(std::string s) {
  for (char& c : s) c = char(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

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
  for (const char* same : {"intensity", "exposure", "lightColor", "enableTemperature", "temperature", "coneAngle", "coneSoftness",
                           "areaNormalize", "emissionFocus", "emissionFocusTint", "diffuse", "specular", "enableShadows"})
    rename(*n, from, same, same);
  return n;
}

// PxrStdAreaLight and its kin: the geometry says the shape. Rectangles and disks shone along -Z then.
bool fromClassic(const scene::Light& l, scene::Light& out) {
  const std::string plugin = lowerCase(l.node->plugin);
  if (plugin != "pxrstdarealight" && plugin != "pxrstdenvmaplight" && plugin != "pxrstdenvdaylight" &&
      plugin != "pxrenvdaylight")
    return false;
  std::string shape = lowerCase(l.node->params.getString("rman__Shape", ""));
  if (l.geometry)
    if (const auto* other = std::get_if<scene::OtherPrimitive>(&l.geometry->shape))
      if (const scene::Parameter* name = other->args.find("name"); name && !name->strings.empty()) shape = lowerCase(name->strings[0]);
  if (l.geometry && std::holds_alternative<scene::Quadric>(l.geometry->shape) &&
      std::get<scene::Quadric>(l.geometry->shape).kind == scene::Quadric::Kind::Sphere)
    shape = "sphere";
  out = l;
  if (l.geometry) out.toWorld = l.geometry->toWorld;
  out.geometry.reset();
  const auto has = [&](const char* word) { return shape.find(word) != std::string::npos; };
  if (plugin != "pxrstdarealight" || has("env")) {
    auto n = makeNode(*l.node, "PxrDomeLight");
    rename(*n, *l.node, "rman__EmissionMap", "lightColorMap");
    rename(*n, *l.node, "rman__EnvMap", "lightColorMap");
    rename(*n, *l.node, "envTint", "lightColor");
    rename(*n, *l.node, "skyTint", "lightColor");
    out.node = n;
  } else if (has("sphere")) {
    out.node = makeNode(*l.node, "PxrSphereLight");
    if (l.geometry && std::holds_alternative<scene::Quadric>(l.geometry->shape)) {
      const double r = 2 * std::get<scene::Quadric>(l.geometry->shape).args[0];
      out.toWorld = scaled(out.toWorld, r, r, r);
    }
  } else if (has("distant")) {
    out.node = makeNode(*l.node, "PxrDistantLight");
  } else {
    out.node = makeNode(*l.node, "PxrRectLight");
    double s = has("disk") ? std::sqrt(3.14159265358979) / 2 : 1;   // a square of the disk's area
    if (l.geometry)
      if (const auto* q = std::get_if<scene::Quadric>(&l.geometry->shape); q && q->kind == scene::Quadric::Kind::Disk)
        s = std::sqrt(3.14159265358979) * q->args[1];
    out.toWorld = scaled(out.toWorld, s, s, -1);
  }
  return true;
}

}  // namespace

std::vector<scene::Light> lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics,
                                         std::set<uint32_t>& shapes) {
  std::vector<scene::Light> all = scene.lights;
  // lights inside prototypes shine from every instance, with the instance's attributes
  constexpr size_t kMost = 1'000'000;
  const auto instantiate = [&](const auto& self, const scene::Instance& inst, const scene::Transform& toWorld, int depth) -> void {
    if (inst.prototype >= scene.prototypes.size() || depth > 32 || all.size() > kMost) return;
    const scene::Prototype& p = scene.prototypes[inst.prototype];
    for (scene::Light l : p.lights) {
      l.toWorld = concat(l.toWorld, toWorld);
      if (inst.attributes) l.attributes = inst.attributes;
      all.push_back(std::move(l));
    }
    for (const scene::Instance& nested : p.instances) self(self, nested, concat(nested.toWorld, toWorld), depth + 1);
  };
  for (const scene::Instance& i : scene.instances) instantiate(instantiate, i, i.toWorld, 0);
  for (const scene::Light& l : scene.classicLights) {
    scene::Light out;
    if (!l.node || !fromClassic(l, out)) continue;
    if (l.geometry) shapes.insert(l.geometry->id);
    diagnostics.warning("RENDER-CLASSIC-LIGHT", l.node->pos, l.node->kind + " '" + l.node->plugin + "' is of an old kind",
                        out.node->plugin + " stands in");
    all.push_back(std::move(out));
  }
  struct Substitute { const char *missing, *use; double x, y; };
  static constexpr double kDisk = 0.886226925;
  static constexpr Substitute kTable[] = {{"pxrdisklight", "PxrRectLight", kDisk, kDisk}, {"pxrcylinderlight", "PxrSphereLight", 1, 1},
                                          {"pxrenvdaylight", "PxrDomeLight", 1, 1}, {"pxrstdenvmaplight", "PxrDomeLight", 1, 1}};
  for (scene::Light& l : all) {
    if (!l.node) continue;
    Diagnostics quiet([](const std::string&, Severity) {});
    if (registry.find(Kind::Light, l.node->plugin, quiet, l.node->pos)) continue;
    for (const Substitute& s : kTable) {
      if (lowerCase(l.node->plugin) != s.missing) continue;
      auto n = makeNode(*l.node, s.use);
      rename(*n, *l.node, "rman__EnvMap", "lightColorMap");
      rename(*n, *l.node, "skyTint", "lightColor");
      diagnostics.warning("PLUGIN-STAND-IN", l.node->pos, "no light '" + l.node->plugin + "' (node '" + l.node->handle + "')",
                          std::string(s.use) + " of about the same power stands in");
      l.node = n;
      l.toWorld = scaled(l.toWorld, s.x, s.y, 1);
      break;
    }
  }
  return all;
}

}  // namespace kinora::render
