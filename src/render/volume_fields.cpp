#include "render/volume_fields.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "render/instance.h"
#include "volume/grid_stream.h"
#include "volume/volume_system.h"

namespace kinora::render {

namespace {

constexpr uint64_t kMostVoxels = uint64_t(1) << 30;  // of a request

// "vel.x" -> "vel", 0.
std::pair<std::string, int> partOfGrid(const std::string& name) {
  const size_t n = name.size();
  if (n > 2 && name[n - 2] == '.' && name[n - 1] >= 'x' && name[n - 1] <= 'z')
    return {name.substr(0, n - 2), name[n - 1] - 'x'};
  return {name, -1};
}

class Fields {
 public:
  Fields(const scene::Primitive& p, const scene::OtherPrimitive& volume, const VolumeTools& tools)
      : p_(p), volume_(volume), tools_(tools) {}

  void read(shade::SpaceMedium& medium) {
    const scene::Parameter* texts = p_.primvars.find("blobbydso:stringargs");
    const std::string type = volume_.args.getString("type", ""), prefix = "blobbydso:";
    const bool isGrids = type.starts_with(prefix + "impl_openvdb");
    if (isGrids && texts && !texts->strings.empty()) file_ = texts->strings[0];
    if (!isGrids && type.starts_with(prefix)) ofPlugin(type.substr(prefix.size()), medium);
    std::string said = texts && texts->strings.size() > 1 ? texts->strings[1] : "";
    said.resize(std::min(said.find(':'), said.size()));  // "density:fogvolume"
    if (isGrids && texts && texts->strings.size() > 3) readMore(texts->strings[3]);
    for (const scene::Parameter& v : p_.primvars) {
      if (v.storage == scene::StorageClass::Constant || v.name.starts_with("blobbydso:")) continue;
      if (medium.fields.contains(v.name)) continue;
      if (v.floats.empty() && v.ints.empty() && !file_.empty())
        ofFile(v.name, medium);
      else if (v.floats.empty() && v.ints.empty())
        standIn(v.name, medium);
      else
        ofRequest(v, medium);
    }
    if (!file_.empty() && medium.fields.empty()) ofFile(said.empty() ? "density" : said, medium);
  }
  // The width of footprints by which levels of the grids are chosen over that of rays; 0: the finest alone.
  float filterWidth() const { return filterWidth_; }

 private:
  // The fourth string of a request for grids, as exporters write it: a dictionary.
  void readMore(const std::string& text) {
    if (text.empty()) return;
    const auto said = nlohmann::json::parse(text, nullptr, false);
    const auto it = said.is_object() ? said.find("filterWidth") : said.end();
    const bool isNumber = it != said.end() && it->is_number();
    if (isNumber && it->get<double>() >= 0 && it->get<double>() <= kWidest) {
      filterWidth_ = it->get<float>();
    } else if (!said.is_object() || it != said.end()) {
      tools_.diagnostics.warning("MEDIUM-FIELD", p_.pos,
                                 said.is_object() ? "\"filterWidth\" of Volume is not a number from 0 to 1000"
                                                  : "the fourth string of \"blobbydso:stringargs\" is no dictionary",
                                 "its grids are looked up as without it", R"(write {"filterWidth": 1})");
    }
    for (const auto& [name, none] : {std::pair("densityMult", 1.0), {"densityRolloff", 0.0}, {"velocityScale", 1.0}})
      if (said.is_object() && said.contains(name) && !(said[name].is_number() && said[name].get<double>() == none))
        tools_.diagnostics.warning("MEDIUM-FIELD", p_.pos, std::string("\"") + name + "\" of Volume is not known",
                                   "it has no effect",
                                   "densityFloat and velocityMultiplier of PxrVolume are factors");
  }
  void ofFile(const std::string& name, shade::SpaceMedium& medium) {
    const auto [grid, component] = partOfGrid(name);
    const volume::VoxelGrid* found =
        tools_.volumes.grid(file_, volume::gridByName(grid), "Volume at " + p_.pos.str());
    if (!found) {
      if (component >= 0) found = tools_.volumes.grid(file_, volume::gridByName(name), "Volume at " + p_.pos.str());
      if (!found) return standIn(name, medium);
      medium.fields.emplace(name, volume::MediumField(found));
      return;
    }
    medium.fields.emplace(name, volume::MediumField(found, component < found->shape().channels ? component : -1));
  }

  // Fields that a volume plug-in computes; its parameters are the constants of the request.
  void ofPlugin(const std::string& name, shade::SpaceMedium& medium) {
    const Descriptor* plugin = tools_.registry.find(Kind::Volume, name, tools_.diagnostics, p_.pos);
    if (!plugin) {
      tools_.diagnostics.warning("PLUGIN-MISSING", p_.pos, "there is no volume plug-in '" + name + "'",
                                 "a mist stands for its fields");
      return;
    }
    scene::Node node;
    node.kind = "Volume";
    node.plugin = name;
    node.handle = p_.name();
    node.pos = p_.pos;
    for (const scene::Parameter& v : p_.primvars)
      if (v.storage == scene::StorageClass::Constant) node.params.set(v);
    Instance instance;
    const auto* traits = static_cast<const VolumeTraits*>(plugin->traits);
    const auto* functions = static_cast<const VolumeFunctions*>(functionsFor(*plugin, 8));
    if (!functions || !traits || !traits->extremes ||
        !instance.create(*plugin, &node, nullptr, nullptr, tools_.host, tools_.diagnostics))
      return;
    for (uint32_t k = 0; k < traits->fieldCount; ++k)
      medium.fields.emplace(traits->fields[k].name, volume::MediumField(*functions, *traits, k, instance.owner()));
  }

  // So that one sees where the volume would be: a mist that lets half of the light through, seen along its shortest
  // side.
  void standIn(const std::string& name, shade::SpaceMedium& medium) {
    const std::vector<float> bound = volume_.args.getFloats("bound");
    if (bound.size() != 6) return;
    float shortest = INFINITY;
    for (size_t k = 0; k < 3; ++k) shortest = std::min(shortest, bound[2 * k + 1] - bound[2 * k]);
    const int one[3] = {1, 1, 1};
    const float value = 0.7f / std::max(shortest, 1e-6f);
    medium.fields.emplace(name, volume::MediumField(bound.data(), one, &value, 1));
  }

  void ofRequest(const scene::Parameter& v, shade::SpaceMedium& medium) {
    const scene::Parameter* sizes = volume_.args.find("dimensions");
    const std::vector<float> bound = volume_.args.getFloats("bound");
    int n[3] = {1, 1, 1};
    uint64_t all = 1;
    for (size_t k = 0; k < 3; ++k) {
      if (sizes && sizes->ints.size() == 3) n[k] = std::max(sizes->ints[k], 1);
      all = std::min(all * uint64_t(n[k]), 2 * kMostVoxels);
    }
    const size_t given = v.floats.size();
    const int components = given == 3 * all ? 3 : 1;
    if (bound.size() != 6) return;
    if (all > kMostVoxels || (given != all && given != 3 * all)) {
      tools_.diagnostics.warning("MEDIUM-FIELD", v.pos,
                                 "\"" + v.name + "\" of Volume has " + std::to_string(given) + " numbers; its " +
                                     std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " +
                                     std::to_string(n[2]) + " points take one or three each",
                                 "the volume is without it");
      return;
    }
    medium.fields.emplace(v.name, volume::MediumField(bound.data(), n, v.floats.data(), components));
  }

  const scene::Primitive& p_;
  const scene::OtherPrimitive& volume_;
  const VolumeTools& tools_;
  std::string file_;
  static constexpr double kWidest = 1000;
  float filterWidth_ = 1;
};
}  // namespace

const scene::OtherPrimitive* volumeRequestOf(const scene::Primitive& p) {
  const auto* other = std::get_if<scene::OtherPrimitive>(&p.shape);
  return other && other->request == "Volume" ? other : nullptr;
}

float readVolumeFields(const scene::Primitive& p, const VolumeTools& tools, shade::SpaceMedium& medium) {
  Fields fields(p, *volumeRequestOf(p), tools);
  fields.read(medium);
  return fields.filterWidth();
}

void setVolumeMotion(const shade::MaterialSet::Extinction& e, const scene::Primitive& p, const VolumeTools& tools,
                     shade::SpaceMedium& m) {
  const double open = tools.camera.shutterOpen, close = tools.camera.shutterClose;
  if (!(close > open)) return;
  const auto find = [&](const std::string& name) {
    const auto it = m.fields.find(name);
    return it == m.fields.end() ? nullptr : &it->second;
  };
  m.velocityFactor = e.velocityFactor;
  std::copy_n(e.constantVelocity, 3, m.constantVelocity);
  if (!e.velocity.empty()) {
    const volume::MediumField* all = find(e.velocity);
    const char* const parts[3] = {".x", ".y", ".z"};
    bool isThere = false;
    for (int k = 0; k < 3; ++k) {
      m.velocity[k] = all && all->components() == 3 ? all : find(e.velocity + parts[k]);
      isThere |= m.velocity[k] != nullptr;
    }
    if (!isThere)
      tools.diagnostics.warning("MEDIUM-VELOCITY", p.pos,
                                "'" + p.name() + "' has no velocity '" + e.velocity + "' of three components",
                                "its medium stands still", "velocityPrimVar names a primvar of the Volume");
  }
  const bool isNear = open <= 0 && close >= 0;
  m.opens = isNear ? float(open) : 0.f;
  m.lasts = float(close - open);
  const float longest = std::max(std::fabs(m.opens), std::fabs(m.opens + m.lasts));
  bool isFar = false;
  for (int k = 0; k < 3; ++k) {
    float speed = std::fabs(m.constantVelocity[k]);
    if (const volume::MediumField* v = m.velocity[k])
      speed += std::fabs(m.velocityFactor) * v->largest(v->components() == 3 ? k : 0, m.low, m.high);
    const float extent = m.high[k] - m.low[k];
    float way = speed * longest;
    if (!(way <= extent)) {
      isFar = true;
      way = extent;
    }
    m.farthest[k] = way;
    m.isCarried |= way > 0;
  }
  if (isFar)
    tools.diagnostics.warning(
        "MEDIUM-VELOCITY", p.pos,
        "the velocity of '" + p.name() + "' carries it farther than it is large in the shutter's time",
        "it is carried by its own size at most",
        "velocityMultiplier scales it; velocities are by unit of the shutter's time");
}

}  // namespace kinora::render
