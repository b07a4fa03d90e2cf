#include "render/classic_lights.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <optional>

#include "base/text.h"

namespace kinora::render {

namespace {

constexpr double kPi = 3.14159265358979;

// Shaped: the controls of Barzel's model. Rect: a square of side 1 in the light's space, as shaders sampled it.
// Nothing: no light of its own.
enum class Emitter { Nothing, Ambient, Distant, Point, Spot, Shaped, Dome, Rect };

struct Word {
  const char* word;
  Emitter emitter;
};
// The first word that a name holds counts.
constexpr Word kWords[] = {{"ambient", Emitter::Ambient},  {"caustic", Emitter::Nothing},
                           {"photon", Emitter::Nothing},   {"bounce", Emitter::Nothing},
                           {"indirect", Emitter::Nothing}, {"env", Emitter::Dome},
                           {"dome", Emitter::Dome},        {"sky", Emitter::Dome},
                           {"uber", Emitter::Shaped},      {"distant", Emitter::Distant},
                           {"solar", Emitter::Distant},    {"sun", Emitter::Distant},
                           {"window", Emitter::Distant},   {"directional", Emitter::Distant},
                           {"spot", Emitter::Spot},        {"point", Emitter::Point},
                           {"omni", Emitter::Point},       {"volume", Emitter::Point},
                           {"area", Emitter::Rect}};

std::optional<Emitter> emitterOf(const std::string& name) {
  for (const Word& w : kWords)
    if (name.find(w.word) != std::string::npos) return w.emitter;
  return {};
}

using Names = std::initializer_list<const char*>;

class Maker {
 public:
  explicit Maker(const scene::Light& light) : light_(light), given_(light.node->params) {
    node_ = std::make_shared<scene::Node>();
    node_->kind = "Light";
    node_->handle = light.node->handle;
    node_->pos = light.node->pos;
  }

  bool make(bool isPathTraced, scene::Light& out, std::string& why) {
    const std::string name = lowerCase(light_.node->plugin.substr(light_.node->plugin.find_last_of("/\\") + 1));
    out = light_;
    if (light_.geometry) {
      area(name, out);
    } else {
      Emitter e = kind(name);
      if (e == Emitter::Nothing) {
        why = "it brings no light of its own that paths do not find";
        return false;
      }
      if (e == Emitter::Shaped) {
        const std::string type = lowerCase(given_.getString("lighttype", "spot"));
        if (type == "arealight" || type == "area") e = Emitter::Rect;
      }
      place(e, out);
      shine(e, name);
    }
    // domes are what occlusion was made with; ambient light has its own
    if (node_->plugin != "PxrDomeLight" && !isPathTraced && !hasShadows()) setInt(*node_, "enableShadows", 0);
    color();
    kinds();
    out.node = node_;
    if (filter_) usualDistance(out);
    if (filter_) out.filters = {filter_};
    out.filterToWorld.assign(out.filters.size(), out.toWorld);
    hide(out);
    return true;
  }

 private:
  const scene::Parameter* find(Names names) const {
    for (const char* n : names)
      if (const scene::Parameter* p = given_.find(n)) return p;
    return nullptr;
  }
  double number(Names names, double fallback) const {
    const scene::Parameter* p = find(names);
    const double v = p ? given_.getFloat(p->name, float(fallback)) : fallback;
    return std::isfinite(v) ? v : fallback;
  }
  std::optional<Imath::V3d> point(const char* name) const {
    const std::vector<float> v = given_.getFloats(name);
    if (v.size() < 3) return {};
    return Imath::V3d(v[0], v[1], v[2]);
  }
  static void set(scene::Node& n, const char* name, double value) {
    scene::Parameter p;
    p.name = name;
    p.floats = {float(value)};
    n.params.set(std::move(p));
  }
  static void setInt(scene::Node& n, const char* name, int value) {
    scene::Parameter p;
    p.name = name;
    p.type = scene::ValueType::Int;
    p.ints = {value};
    n.params.set(std::move(p));
  }

  bool hasShadows() const {
    if (light_.attributes) {
      const std::string said = lowerCase(light_.attributes->named.getString("light:shadows", ""));
      if (!said.empty()) return said != "off" && said != "none";
    }
    const std::string plugin = lowerCase(light_.node->plugin);
    // _rts: of ray traced shadows
    if (light_.geometry || plugin.find("shadow") != std::string::npos || plugin.find("area") != std::string::npos ||
        plugin.ends_with("_rts"))
      return true;
    return std::any_of(given_.begin(), given_.end(), [&](const scene::Parameter& p) {
      const std::string name = lowerCase(p.name);
      const bool isMap = name.find("shadow") != std::string::npos && !p.strings.empty() && !p.strings[0].empty();
      return isMap || (name.find("raytrace") != std::string::npos && given_.getFloat(p.name, 0) != 0);
    });
  }

  // By name, by the handle where an exporter gave them the wrong way round, then by parameters.
  Emitter kind(const std::string& name) const {
    if (const auto e = emitterOf(name)) return *e;
    if (const auto e = emitterOf(lowerCase(light_.node->handle))) return *e;
    if (find({"lighttype", "wedge", "roundness", "cuton", "superellipse"})) return Emitter::Shaped;
    if (find({"coneangle", "coneAngle", "penumbraAngle", "penumbraangle"})) return Emitter::Spot;
    if (find({"to", "direction"})) return Emitter::Distant;
    if (find({"from", "falloff", "decay", "decayRate"})) return Emitter::Point;
    // light that falls with the square of the distance has large numbers
    if (find({"intensity", "lightcolor", "lightColor"}))
      return number({"intensity"}, 1) <= 4 ? Emitter::Distant : Emitter::Point;
    return Emitter::Nothing;
  }

  // Local +Z along the axis from `from` to `to`, or along +Z of the light's space.
  void place(Emitter e, scene::Light& out) const {
    const std::optional<Imath::V3d> from = point("from"), to = point("to");
    const std::optional<Imath::V3d> along = point("direction");
    const Imath::V3d start = from.value_or(Imath::V3d(0)), end = to.value_or(Imath::V3d(0, 0, 1));
    Imath::V3d axis = along && !to ? *along : end - start;
    axis = axis.length() > 0 ? axis.normalized() : Imath::V3d(0, 0, 1);
    if (!from && !to && !along && (e == Emitter::Shaped || e == Emitter::Rect || e == Emitter::Dome)) {
      out.toWorld = light_.toWorld;
    } else {
      const Imath::V3d side =
          (std::fabs(axis.x) < 0.9 ? Imath::V3d(1, 0, 0) : Imath::V3d(0, 1, 0)).cross(axis).normalized();
      const Imath::V3d up = axis.cross(side);
      const scene::Matrix m(side.x, side.y, side.z, 0, up.x, up.y, up.z, 0, axis.x, axis.y, axis.z, 0, start.x,
                            start.y, start.z, 1);
      out.toWorld = concat(scene::Transform::fixed(m), light_.toWorld);
    }
    if (e == Emitter::Ambient) out.toWorld = scene::Transform();
  }

  // Such lights met surfaces without the 1 / pi of a Lambert surface: a point light of intensity I gives irradiance
  // pi I / d^2 here. Distances are those of the world, whatever scale the light was declared under: its shader
  // computed with the vector from the light to the surface in world space. Ambient light has no direction: nothing
  // shadows it, and no mirror or highlight shows it. It is all that arrives by way of other surfaces, so that what
  // these send on of it does not count again.
  void shine(Emitter e, const std::string& name) {
    const double intensity = number({"intensity"}, 1);
    const bool hasRays = number({"parallelrays"}, 0) != 0;
    switch (e) {
      case Emitter::Ambient:
        node_->plugin = "PxrDomeLight";
        set(*node_, "intensity", intensity);
        setInt(*node_, "enableShadows", 0);
        setInt(*node_, "__indirect", 0);
        set(*node_, "specular", 0);
        break;
      case Emitter::Dome: {
        node_->plugin = "PxrDomeLight";
        set(*node_, "intensity", intensity);
        if (const scene::Parameter* map = find({"rman__EnvMap", "envmap", "envname", "mapname", "texturename"});
            map && !map->strings.empty() && !map->strings[0].empty()) {
          scene::Parameter p = *map;
          p.name = "lightColorMap";
          node_->params.set(std::move(p));
        }
        break;
      }
      case Emitter::Distant:
        node_->plugin = "PxrDistantLight";
        set(*node_, "angleExtent", 0);
        set(*node_, "intensity", kPi * intensity);
        break;
      case Emitter::Rect:
        node_->plugin = "PxrRectLight";
        setInt(*node_, "areaNormalize", 1);
        set(*node_, "intensity", perArea(name) * intensity);
        break;
      case Emitter::Shaped:
        node_->plugin = hasRays ? "PxrDistantLight" : "PointLight";
        if (hasRays) set(*node_, "angleExtent", 0);
        set(*node_, "intensity", kPi * intensity);
        shape(hasRays);
        break;
      default:
        node_->plugin = "PointLight";
        set(*node_, "intensity", kPi * intensity);
        if (e == Emitter::Spot) cone();
        distance(name);
    }
  }

  // The plausible shaders of 2011 gave the power of a light, to surfaces with their 1 / pi.
  static double perArea(const std::string& name) {
    return name.find("plausible") != std::string::npos ? 1 / kPi : kPi;
  }

  // Angles are radians, half of the cone; exporters of other programs wrote degrees, all of it and a penumbra around.
  void cone() {
    double angle = number({"coneangle", "coneAngle"}, 0.5235988);
    double delta = number({"conedeltaangle", "coneDeltaAngle"}, 0.0872665);
    if (angle > kPi) {
      const double penumbra = number({"penumbraAngle", "penumbraangle"}, 0) * kPi / 180;
      angle = angle / 2 * kPi / 180 + std::max(0.0, penumbra);
      delta = std::fabs(penumbra);
    }
    set(*node_, "coneAngle", std::min(angle, kPi) * (180 / kPi));
    set(*node_, "coneDeltaAngle", std::min(delta, kPi) * (180 / kPi));
    set(*node_, "beamDistribution", number({"beamdistribution", "beamDistribution", "dropoff"}, 2));
  }

  // Another exponent of the distance than 2.
  void distance(const std::string& name) {
    const double exponent =
        name.find("nofalloff") != std::string::npos ? 0 : number({"falloff", "decay", "decayRate"}, 2);
    if (exponent == 2) return;
    scene::Node& f = filter();
    setInt(f, "shape", 1);
    set(f, "falloff", exponent);
  }
  void shape(bool hasRays) {
    scene::Node& f = filter();
    const bool isOmni = lowerCase(given_.getString("lighttype", "spot")) == "omni";
    setInt(f, "shape", hasRays ? 2 : isOmni ? 1 : 0);
    for (const char* same : {"width", "height", "wedge", "hedge", "roundness", "shearx", "sheary", "cuton", "cutoff",
                             "nearedge", "faredge", "falloff", "falloffdist", "maxintensity", "beamdistribution"})
      if (const scene::Parameter* p = given_.find(same); p && p->size() == 1 && p->strings.empty())
        set(f, same, given_.getFloat(same, 0));
  }
  scene::Node& filter() {
    auto f = std::make_shared<scene::Node>();
    f->kind = "LightFilter";
    f->plugin = "BarzelLightFilter";
    f->handle = node_->handle;
    f->pos = node_->pos;
    filter_ = f;
    return *f;
  }
  // Lights are chosen by what they bring at the distance of a point. One that does not fall with its square is chosen
  // well where that of a point light would be the same: about as far as it stands from the origin.
  void usualDistance(const scene::Light& out) {
    const double d = out.toWorld.at(0).translation().length();
    if (node_->plugin == "PxrDistantLight" || !(d > 0) || !(d < 1e9)) return;
    set(*filter_, "fromDistance", d);
    set(*node_, "intensity", node_->params.getFloat("intensity", 0) * d * d);
  }

  // What a shader of area lights gave was that of a point light, spread over the shape: it did not grow with it. A
  // falloff of its own makes the shape itself look wrong, which is then not shown.
  void area(const std::string& name, scene::Light& out) {
    node_->plugin = "PxrMeshLight";
    setInt(*node_, "areaNormalize", 1);
    set(*node_, "intensity", perArea(name) * number({"intensity"}, 1));
    out.toWorld = light_.geometry->toWorld;
    out.attributes = light_.geometry->attributes ? light_.geometry->attributes : light_.attributes;
    out.geometry = light_.geometry;
    if (std::holds_alternative<scene::OtherPrimitive>(light_.geometry->shape)) {  // a shape by its name
      node_->plugin = "PxrRectLight";
      out.geometry.reset();
      scene::Matrix m;
      m.setScale(Imath::V3d(1, 1, -1));  // such shapes shone along -Z
      out.toWorld = concat(scene::Transform::fixed(m), out.toWorld);
    }
    const bool isShaped = emitterOf(name) == Emitter::Shaped;
    const double exponent = number({"falloff", "decay", "decayRate"}, isShaped ? 0 : 2);
    if (exponent == 2) return;
    scene::Node& f = filter();
    setInt(f, "shape", 1);
    set(f, "falloff", exponent);
    isHidden_ = true;
  }

  void color() {
    const scene::Parameter* c = find({"lightcolor", "lightColor", "cl", "color"});
    if (!c || c->floats.size() != 3) return;
    scene::Parameter p = *c;
    p.name = "lightColor";
    p.type = scene::ValueType::Color;
    p.isArray = false;
    p.arrayLength = 1;
    node_->params.set(std::move(p));
  }
  // What lights said of themselves to surface shaders.
  void kinds() {
    if (find({"__nondiffuse", "nondiffuse"}))
      set(*node_, "diffuse", std::clamp(1 - number({"__nondiffuse", "nondiffuse"}, 0), 0.0, 1.0));
    if (find({"__nonspecular", "nonspecular"}))
      set(*node_, "specular", std::clamp(1 - number({"__nonspecular", "nonspecular"}, 0), 0.0, 1.0));
  }

  // Nobody saw a LightSource.
  void hide(scene::Light& out) const {
    if (light_.geometry && !isHidden_) return;
    auto unseen =
        out.attributes ? std::make_shared<scene::Attributes>(*out.attributes) : std::make_shared<scene::Attributes>();
    for (const char* what : {"visibility:camera", "visibility:indirect"}) {
      if (!isHidden_ && std::string_view(what) != "visibility:camera") continue;
      scene::Parameter p;
      p.name = what;
      p.type = scene::ValueType::Int;
      p.ints = {0};
      unseen->named.set(std::move(p));
    }
    out.attributes = unseen;
  }

  const scene::Light& light_;
  const scene::ParameterList& given_;
  std::shared_ptr<scene::Node> node_;
  std::shared_ptr<scene::Node> filter_;
  bool isHidden_ = false;
};

}  // namespace

bool classicLight(const scene::Light& light, bool isPathTraced, scene::Light& out, std::string& why) {
  return Maker(light).make(isPathTraced, out, why);
}

}  // namespace kinora::render
