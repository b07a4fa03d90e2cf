#include "render/portals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "render/light_places.h"

namespace kinora::render {

namespace {

bool isOf(const scene::Light& l, const char* plugin) { return l.node && sameName(l.node->plugin, plugin); }

const scene::Light* domeOf(const scene::Light& portal, const std::vector<scene::Light>& lights) {
  const std::string map = portal.node->params.getString("domeColorMap", "");
  for (const scene::Light& l : lights) {
    if (!isOf(l, "PxrDomeLight")) continue;
    if (map.empty() || l.node->params.getString("lightColorMap", "") == map) return &l;
  }
  return nullptr;
}

// Turns do not depend on where render space begins.
CameraState shutterOf(const scene::Scene& scene) {
  CameraState c;
  if (scene.cameras.empty()) return c;
  c.shutterOpen = scene.cameras.front().shutter[0];
  c.shutterClose = std::max(scene.cameras.front().shutter[1], c.shutterOpen);
  return c;
}

scene::Transform withoutShift(scene::Transform t) {
  for (scene::Matrix& m : t.matrices)
    for (int k = 0; k < 3; ++k) m[3][k] = 0;
  return t;
}

// Plug-ins know portal and dome as they rest (light/light_motion.h). What carries a direction through the portal at rest to
// where the dome at rest has what is seen: unit quaternions at even times over the shutter, world space. Empty: nothing
// does, or both turn as one.
std::vector<float> turnsBetween(const scene::Light& portal, const scene::Light& dome, const CameraState& shutter) {
  constexpr float kTurn = 1e-4f;  // of half an angle: what keys of rotations make between them
  if (portal.toWorld.isStatic() && dome.toWorld.isStatic()) return {};
  const scene::Transform p = withoutShift(portal.toWorld), d = withoutShift(dome.toWorld);
  scene::Transform path = concat(d.inverse(), scene::Transform::fixed(d.at(shutter.middle())));
  // one that mirrors on its way is not followed: it rests
  if (movesOf(portal.toWorld, shutter).motion)
    path = concat(scene::Transform::fixed(p.at(shutter.middle()).inverse()), concat(p, path));
  const std::shared_ptr<const light::LightMotion> motion = movesOf(path, shutter).motion;
  if (!motion) return {};
  std::vector<float> turns;
  bool doTurn = false;
  for (const light::LightMotion::Pose& pose : motion->poses) {
    turns.insert(turns.end(), pose.turn, pose.turn + 4);
    for (int k = 1; k < 4; ++k) doTurn |= std::fabs(pose.turn[k]) > kTurn;
  }
  if (!doTurn) turns.clear();
  return turns;
}

// The portal's own values stand before those of the dome, but for what the dome's are multiplied by.
scene::NodePtr shownBy(const scene::Light& portal, const scene::Light& dome, const CameraState& shutter) {
  auto node = std::make_shared<scene::Node>(*portal.node);
  const auto take = [&](const char* from, const char* to) {
    const scene::Parameter* p = dome.node->params.find(from);
    if (!p || node->params.find(to)) return;
    scene::Parameter q = *p;
    q.name = to;
    node->params.set(q);
  };
  take("lightColorMap", "domeColorMap");
  for (const char* same : {"intensity",
                           "exposure",
                           "lightColor",
                           "enableTemperature",
                           "temperature",
                           "specular",
                           "diffuse",
                           "colorMapGamma",
                           "colorMapSaturation",
                           "lightGroup",
                           "enableShadows",
                           "shadowColor",
                           "shadowDistance",
                           "shadowFalloff",
                           "shadowFalloffGamma",
                           "shadowSubset",
                           "shadowExcludeSubset",
                           "traceLightPaths",
                           "thinShadow",
                           "visibleInRefractionPath"})
    take(same, same);
  if (!node->params.find("portalToDome")) {
    const double middle = shutter.middle();
    const scene::Matrix m = portal.toWorld.at(middle) * dome.toWorld.at(middle).inverse();
    scene::Parameter p;
    p.name = "portalToDome";
    p.type = scene::ValueType::Matrix;
    for (int i = 0; i < 16; ++i) p.floats.push_back(float(m[i / 4][i % 4]));
    node->params.set(p);
    scene::Parameter turns;
    turns.name = "domeTurns";
    turns.type = scene::ValueType::Float;
    turns.floats = turnsBetween(portal, dome, shutter);
    turns.isArray = true;
    turns.arrayLength = int(turns.floats.size());
    if (!turns.floats.empty()) node->params.set(turns);
  }
  return node;
}

}  // namespace

ShownDomes openPortals(const scene::Scene& scene, std::vector<scene::Light>& lights, Diagnostics& diagnostics) {
  ShownDomes shown;
  std::map<const scene::Light*, std::shared_ptr<const scene::Light>> closed;
  const CameraState shutter = shutterOf(scene);
  for (scene::Light& l : lights) {
    if (!isOf(l, "PxrPortalLight")) continue;
    if (const scene::Light* dome = domeOf(l, lights)) {
      const auto [it, isNew] = closed.try_emplace(dome);
      if (isNew) {
        it->second = std::make_shared<const scene::Light>(*dome);
        warnOfShape(*dome, movesOf(dome->toWorld, shutter), diagnostics);
      }
      l.node = shownBy(l, *dome, shutter);
      shown[l.node.get()] = it->second;
    } else if (l.node->params.getString("domeColorMap", "").empty()) {
      diagnostics.warning("LIGHT-PORTAL", l.node->pos, "portal '" + l.node->handle + "' has no dome to show",
                          "it is even and of its own colour", "add a PxrDomeLight, or name a map as domeColorMap");
    }
  }
  size_t kept = 0;
  for (size_t i = 0; i < lights.size(); ++i)
    if (!closed.contains(&lights[i])) {
      if (kept != i) lights[kept] = std::move(lights[i]);
      ++kept;
    }
  lights.resize(kept);
  return shown;
}

}  // namespace kinora::render
