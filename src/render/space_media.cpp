#include "render/space_media.h"

#include <nlohmann/json.hpp>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <variant>

#include "render/instance.h"
#include "render/shading_floats.h"
#include "render/world_lights.h"
#include "volume/grid_stream.h"
#include "volume/volume_system.h"

namespace kinora::render {

namespace {

constexpr int kCells = 48;                           // of bounds along the longest side
constexpr int kEmissionCells = 24;                   // of emission
constexpr int kCoarse = 3, kFine = 6;                // points along a cell's side that are looked at
constexpr uint32_t kPointsAtOnce = 1024;             // of a context
constexpr uint64_t kMostVoxels = uint64_t(1) << 30;  // of a request
// Optical thickness that a voxel of a coarser level may have. What gets through means of densities is less than the mean of
// what gets through, by half the variance of the thickness: at most 1 / 8 of the square of this where a voxel holds
// anything between nothing and that.
constexpr float kThickest = 0.25f;

const scene::OtherPrimitive* requestOf(const scene::Primitive& p) {
  const auto* other = std::get_if<scene::OtherPrimitive>(&p.shape);
  return other && other->request == "Volume" ? other : nullptr;
}

// Positive: the normals point outward.
double signedVolume(const geometry::Mesh& mesh) {
  double six = 0;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const Imath::V3d a(mesh.points[mesh.indices[i]]), b(mesh.points[mesh.indices[i + 1]]),
        c(mesh.points[mesh.indices[i + 2]]);
    six += a.dot(b.cross(c));
  }
  return six;
}

// Whether a mesh is its bound, closed and nothing else: all points are corners of it, and they enclose as much.
bool isBox(const geometry::Mesh& mesh) {
  if (mesh.keyCount() > 1 || mesh.triangleCount() != 12) return false;
  const Imath::V3d size = mesh.bounds.max - mesh.bounds.min;
  for (const Imath::V3f& p : mesh.points)
    for (int k = 0; k < 3; ++k) {
      const double at = double(p[k]) + mesh.origin[k] - mesh.bounds.min[k];
      if (std::min(std::fabs(at), std::fabs(at - size[k])) > 1e-6 * size[k]) return false;
    }
  const double volume = size.x * size.y * size.z;
  return volume > 0 && std::fabs(std::fabs(signedVolume(mesh)) / 6 - volume) < 1e-5 * volume;
}

// "vel.x" -> "vel", 0.
std::pair<std::string, int> partOfGrid(const std::string& name) {
  const size_t n = name.size();
  if (n > 2 && name[n - 2] == '.' && name[n - 1] >= 'x' && name[n - 1] <= 'z')
    return {name.substr(0, n - 2), name[n - 1] - 'x'};
  return {name, -1};
}

class Fields {
 public:
  Fields(const scene::Primitive& p, const scene::OtherPrimitive& volume, const SpaceMediaStage::Tools& tools)
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
  const SpaceMediaStage::Tools& tools_;
  std::string file_;
  static constexpr double kWidest = 1000;
  float filterWidth_ = 1;
};

// How far the grids of a medium are carried while the shutter is open. They stand for time 0, or for when the shutter
// opens where that is never.
void setMotion(const shade::MaterialSet::Extinction& e, const scene::Primitive& p,
               const SpaceMediaStage::Tools& tools, shade::SpaceMedium& m) {
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

// The boundary of what is carried so far to all sides.
std::shared_ptr<geometry::Mesh> grown(const geometry::Mesh& mesh, const float by[3]) {
  auto larger = std::make_shared<geometry::Mesh>(mesh);
  const Imath::V3d center = 0.5 * (mesh.bounds.min + mesh.bounds.max), size = mesh.bounds.max - mesh.bounds.min;
  for (Imath::V3f& p : larger->points)
    for (int k = 0; k < 3; ++k)
      if (size[k] > 0) {
        const double c = center[k] - mesh.origin[k];
        p[k] = float(c + (double(p[k]) - c) * (size[k] + 2 * double(by[k])) / size[k]);
      }
  for (int k = 0; k < 3; ++k) {
    larger->bounds.min[k] -= double(by[k]);
    larger->bounds.max[k] += double(by[k]);
  }
  return larger;
}

// Cells of about the same sides, `most` along the longest of a box.
void cellsOf(const float low[3], const float high[3], int most, int cells[3]) {
  const float longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  for (int k = 0; k < 3; ++k)
    cells[k] = std::clamp(int(std::ceil(float(most) * (high[k] - low[k]) / longest)), 1, most);
}

}  // namespace

bool fillsSpace(const scene::Attributes* attributes, Registry& registry, Diagnostics& diagnostics) {
  if (!attributes || !attributes->bxdf || !attributes->bxdf->terminal) return false;
  const scene::Node& bxdf = *attributes->bxdf->terminal;
  const Descriptor* plugin = registry.find(Kind::Bxdf, bxdf.plugin, diagnostics, bxdf.pos);
  return plugin && plugin->flags & kBxdfFillsSpace;
}

bool isVolume(const FlatScene& flat, size_t kind) {
  return requestOf(*flat.shapeOf(flat.kinds[kind]).primitive) != nullptr;
}

namespace {

// Points of a lattice that are looked at are spread over the shutter.
float timeOf(int point) { return 0.5f * float(point % 3); }

// Channels of the mean extinction over the largest of them, from those of all cells.
void setTint(shade::SpaceMedium& m, const std::vector<std::array<float, 3>>& means) {
  double sum[3] = {0, 0, 0}, whole = 0;
  for (size_t cell = 0; cell < means.size(); ++cell) {
    const std::array<float, 3>& x = means[cell];
    m.majorants.mean(cell) = std::max({x[0], x[1], x[2]});
    whole += double(m.majorants.mean(cell));
    for (int k = 0; k < 3; ++k) sum[k] += double(x[k]);
  }
  for (int k = 0; k < 3; ++k) m.tint[k] = whole > 0 ? float(sum[k] / whole) : 1.f;
}

// A bound that fields give within a cell, of what is looked up at a level of theirs.
float boundOf(const shade::SpaceMedium& m, const volume::Majorants& cells, size_t cell, uint32_t level) {
  float most = std::max({m.factor[0], m.factor[1], m.factor[2], 0.f}), low[3], high[3];
  cells.boundsOf(cell, low, high);
  // lookups round the corners of cells
  for (int k = 0; k < 3; ++k) {
    const float slack = 1e-4f * (high[k] - low[k]) + m.farthest[k];
    low[k] -= slack;
    high[k] += slack;
  }
  if (!(most < 1e30f)) most = 0;
  if (m.number) most *= std::max(m.number->most(low, high, level), 0.f);
  if (m.color) most *= std::max(m.color->most(low, high, level), 0.f);
  return most < 1e30f ? most * 1.00001f : 0.f;
}

// Bounds that fields give.
void boundByFields(shade::SpaceMedium& m) {
  std::vector<std::array<float, 3>> means(m.majorants.count());
  tbb::parallel_for(size_t(0), m.majorants.count(), [&](size_t cell) {
    constexpr int kPoints = 8;
    alignas(64) float low[3], high[3], place[3][kPad], extinction[3][kPad], time[kPad];
    const float* const P[3] = {place[0], place[1], place[2]};
    float* const found[3] = {extinction[0], extinction[1], extinction[2]};
    m.majorants.boundsOf(cell, low, high);
    for (int i = 0; i < int(kPad); ++i) {
      const int point = i % kPoints;
      for (int k = 0; k < 3; ++k) place[k][i] = low[k] + (high[k] - low[k]) * (point >> k & 1 ? 0.75f : 0.25f);
      time[i] = timeOf(point);
    }
    m.productsAt(8, kPoints, P, time, found);
    for (int k = 0; k < 3; ++k) {
      float sum = 0;
      for (int point = 0; point < kPoints; ++point) sum += extinction[k][point];
      means[cell][size_t(k)] = sum * (1.f / kPoints);
    }
    m.majorants[cell] = boundOf(m, m.majorants, cell, 0);
  });
  setTint(m, means);
}

// Which coarser levels of its fields rays see, with bounds of their own, which are lower: means have no peaks. scale: of
// lengths from object space. Not where the medium's networks ask for the fields, which know no levels.
void setLevels(shade::SpaceMedium& m, float filterWidth, float scale) {
  if (!m.isProduct || m.mayEmit || !(filterWidth > 0)) return;
  uint32_t levels = 1;
  float side = 0;  // of a voxel
  for (const volume::MediumField* f : {m.number, m.color})
    if (f) {
      levels = std::max(levels, f->levels());
      side = std::max(side, f->voxelSize() * scale);
    }
  for (uint32_t level = 1; level < levels && side > 0 && side < 1e30f; ++level) {
    side *= 2;
    shade::SpaceMedium::Level next{0.5f * side / filterWidth, m.majorants};
    tbb::parallel_for(size_t(0), next.majorants.count(),
                      [&](size_t cell) { next.majorants[cell] = boundOf(m, next.majorants, cell, level); });
    if (!(next.majorants.largest() * side <= kThickest * std::max(filterWidth, 1.f))) break;
    m.levels.push_back(std::move(next));
  }
}

// What a medium is over a lattice of n points along each side of the listed cells: put(cell, extinction, emission,
// count) of the points of one, each in arrays by channel. Emission is null where it is not wanted.
template <class Put>
void lookAt(const shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
            const volume::Majorants& grid, int n, const std::vector<uint32_t>& cells, bool wantsEmission,
            const std::atomic<bool>* stop, Put&& put) {
  const trace::Affine toRender = world.spaceOf(m.instance, m.geometry).fromRender.inverse();
  const size_t perCell = size_t(n) * size_t(n) * size_t(n);
  const size_t atOnce = std::max<size_t>(1, kPointsAtOnce / perCell);
  tbb::enumerable_thread_specific<std::unique_ptr<shade::GroupState>> groups;
  tbb::parallel_for(size_t(0), (cells.size() + atOnce - 1) / atOnce, [&](size_t chunk) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    const ShadingFloats floats;
    std::unique_ptr<shade::GroupState>& group = groups.local();
    if (!group) group = std::make_unique<shade::GroupState>(world);
    Arena& arena = group->arena();
    const ArenaScope memory(arena);
    const size_t first = chunk * atOnce, last = std::min(first + atOnce, cells.size());
    const uint32_t count = uint32_t((last - first) * perCell), room = padded(count);
    const auto f = [&] { return arena.make<float>(room); };
    float *P[3] = {f(), f(), f()}, *time = f(), *found[3] = {f(), f(), f()}, *glow[3] = {nullptr, nullptr, nullptr};
    if (wantsEmission)
      for (float*& x : glow) x = f();
    uint32_t at = 0;
    for (size_t c = first; c < last; ++c) {
      float from[3], to[3];
      grid.boundsOf(cells[c], from, to);
      for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x) {
            const int step[3] = {x, y, z};
            float p[3], q[3];
            for (int k = 0; k < 3; ++k) p[k] = from[k] + (to[k] - from[k]) * float(step[k]) / float(n - 1);
            toRender.point(p, q);
            for (int k = 0; k < 3; ++k) P[k][at] = q[k];
            time[at++] = m.isCarried ? timeOf(x + y + z) : 0.5f;
          }
    }
    group->lookUpMedium(index, count, P, time, found, glow);
    for (size_t c = first; c < last; ++c) {
      const size_t from = (c - first) * perCell;
      const float *const e[3] = {found[0] + from, found[1] + from, found[2] + from},
                         *const g[3] = {glow[0] ? glow[0] + from : nullptr, glow[0] ? glow[1] + from : nullptr,
                                        glow[0] ? glow[2] + from : nullptr};
      put(cells[c], e, g, perCell);
    }
  });
}

std::vector<uint32_t> allCells(const volume::Majorants& grid) {
  std::vector<uint32_t> cells(grid.count());
  std::iota(cells.begin(), cells.end(), 0u);
  return cells;
}

// f(cell, largest of it and its neighbours, smallest of those) for each cell.
template <class F>
void forNeighbourhoods(const volume::Majorants& m, const std::vector<float>& seen, F&& f) {
  const int c[3] = {m.cells(0), m.cells(1), m.cells(2)};
  for (int z = 0; z < c[2]; ++z)
    for (int y = 0; y < c[1]; ++y)
      for (int x = 0; x < c[0]; ++x) {
        float most = 0, least = INFINITY;
        for (int dz = std::max(z - 1, 0); dz <= std::min(z + 1, c[2] - 1); ++dz)
          for (int dy = std::max(y - 1, 0); dy <= std::min(y + 1, c[1] - 1); ++dy)
            for (int dx = std::max(x - 1, 0); dx <= std::min(x + 1, c[0] - 1); ++dx) {
              const float v = seen[(size_t(dz) * c[1] + dy) * c[0] + dx];
              most = std::max(most, v);
              least = std::min(least, v);
            }
        f((size_t(z) * c[1] + y) * c[0] + x, most, least);
      }
}

// Bounds by looking: coarsely everywhere, then finely where something changes. What a cell shows holds for its
// neighbours too, and a little more.
void boundByShading(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
                    const std::atomic<bool>* stop) {
  std::vector<float> seen(m.majorants.count(), 0.f);
  std::vector<std::array<float, 3>> means(seen.size());
  std::vector<uint32_t> cells = allCells(m.majorants);
  const auto see = [&](uint32_t cell, const float* const extinction[3], const float* const[3], size_t count) {
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (size_t i = 0; i < count; ++i) {
        const float v = extinction[k][i];
        if (!(v < 1e30f)) continue;
        seen[cell] = std::max(seen[cell], v);
        sum += double(v);
      }
      means[cell][size_t(k)] = float(sum / double(count));
    }
  };
  lookAt(m, index, world, m.majorants, kCoarse, cells, false, stop, see);
  cells.clear();
  forNeighbourhoods(m.majorants, seen, [&](size_t cell, float most, float least) {
    if (most > 1.2f * least) cells.push_back(uint32_t(cell));
  });
  lookAt(m, index, world, m.majorants, kFine, cells, false, stop, see);
  setTint(m, means);
  constexpr float kMore = 1.15f;  // between the points of a lattice a pattern may be larger
  forNeighbourhoods(m.majorants, seen, [&](size_t cell, float most, float) { m.majorants[cell] = kMore * most; });
}

// What glows is met by rays even where it is clear: the more often the more it does, so that no few meetings bring all of
// its light; a little also where it was not seen to. side: of a cell, in render units.
void raiseBounds(shade::SpaceMedium& m, const volume::Majorants& grid, const std::vector<float>& emitted,
                 double side) {
  double sum = 0, squares = 0;
  float brightest = 0;
  for (const float e : emitted) {
    sum += double(e);
    squares += double(e) * double(e);
    brightest = std::max(brightest, e);
  }
  if (!(side > 0) || !(side < 1e30)) return;
  const double longest = side * std::max({grid.cells(0), grid.cells(1), grid.cells(2)});
  // as large, and as bright, as something even of the same power and the same mean square
  const double size = squares > 0 ? side * std::cbrt(sum * sum / squares) : longest,
               typical = sum > 0 ? squares / sum : 1;
  constexpr double kMeetings = 8, kMostMeetings = 32;
  for (size_t cell = 0; cell < m.majorants.count(); ++cell) {
    float from[3], to[3];
    m.majorants.boundsOf(cell, from, to);
    for (int k = 0; k < 3; ++k) from[k] = 0.5f * (from[k] + to[k]);
    const float here = m.majorants.count() > 1 ? emitted[grid.cellAt(from)] : brightest;
    const double meetings = std::min(kMeetings * double(here) / typical, kMostMeetings);
    m.majorants[cell] = std::max(m.majorants[cell], float(meetings / size + 1 / longest));
  }
}

// Cells that emit, by looking. What lies beside one counts a little too: a flame's tip may be between the points.
void findEmission(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world, const float low[3],
                  const float high[3], const std::atomic<bool>* stop) {
  int cells[3];
  cellsOf(low, high, kEmissionCells, cells);
  const volume::Majorants grid(low, high, cells);
  std::vector<float> own(grid.count(), 0.f), emitted(grid.count(), 0.f);
  lookAt(m, index, world, grid, kCoarse, allCells(grid), true, stop,
         [&](uint32_t cell, const float* const[3], const float* const emission[3], size_t count) {
           double sum = 0;
           for (int k = 0; k < 3; ++k)
             for (size_t i = 0; i < count; ++i) sum += double(emission[k][i]);
           own[cell] = float(sum / double(3 * count));
         });
  constexpr float kBeside = 0.15f;
  double total = 0;
  forNeighbourhoods(grid, own, [&](size_t cell, float most, float) {
    emitted[cell] = std::max(own[cell], kBeside * most);
    total += double(own[cell]);
  });
  float from[3], to[3];
  grid.boundsOf(0, from, to);
  // of a cell, in render units
  double volume = std::fabs(double(world.spaceOf(m.instance, m.geometry).fromRender.inverse().determinant()));
  for (int k = 0; k < 3; ++k) volume *= double(to[k] - from[k]);
  auto found = std::make_shared<const volume::EmissionCells>(low, high, cells, emitted);
  m.power = float(std::min(4 * 3.14159265358979 * total * volume, 1e24));
  if (!found->isBlack() && m.power > 0) m.emission = std::move(found);
  raiseBounds(m, grid, emitted, std::cbrt(volume));
}

}  // namespace

namespace {

// Aggregates that surfaces name as what is inside of them.
std::vector<std::string> interiorsOf(const shade::MaterialSet& materials) {
  std::vector<std::string> names;
  for (uint32_t i = 0; i < materials.programCount(); ++i)
    for (const shade::ProgramNode& node : materials.program(i).nodes)
      for (uint32_t k = 0; node.plugin && k < node.plugin->paramCount; ++k)
        if (node.plugin->params[k].type == Type::String && node.params[k].text && *node.params[k].text &&
            std::string_view(node.plugin->params[k].name) == "volumeAggregateName")
          for (std::string& n : groupNames(node.params[k].text)) names.push_back(std::move(n));
  return names;
}

}  // namespace

std::shared_ptr<const shade::SpaceMedia> SpaceMediaStage::make(const std::shared_ptr<const FlatScene>& flat,
                                                               const Meshes& meshes, shade::ShadingWorld& world,
                                                               const Tools& tools) {
  Inputs inputs{flat, world.materials, world.world, tools.aggregates};
  if (inputs_.world && inputs == inputs_) {
    tools.contents.again(files_);
    use(world);
    return made_;
  }
  *this = {};
  std::vector<bool> isFilled(flat->kinds.size());
  for (size_t k = 0; k < flat->kinds.size(); ++k) {
    const scene::Primitive& p = *flat->shapeOf(flat->kinds[k]).primitive;
    isFilled[k] = world.materials->fillsSpace(world.placements[k].material);
    if (!isFilled[k] && requestOf(p))
      tools.diagnostics.warning("MEDIUM-NONE", p.pos, "'" + p.name() + "' has a material that is no medium's",
                                "it is left out", "a Volume is filled by Bxdf \"PxrVolume\"");
  }
  std::vector<uint32_t> filled;
  if (std::find(isFilled.begin(), isFilled.end(), true) != isFilled.end())
    for (uint32_t k = 0; k < flat->placements.size(); ++k)
      if (isFilled[flat->placements[k].kind]) filled.push_back(k);
  inputs_ = std::move(inputs);
  if (filled.empty()) return nullptr;

  const FileContents::Listening listening(tools.contents, files_);
  auto media = std::make_shared<shade::SpaceMedia>();
  static std::atomic<uint64_t> lastSerial{0};
  media->serial = ++lastSerial;
  std::map<uint32_t, uint32_t> instanceOf;  // by placement
  for (uint32_t i = 0; i < world.world->instanceCount(); ++i)
    if (isFilled[world.world->instance(i).info]) instanceOf.emplace(world.world->instance(i).user, i);
  std::map<const geometry::Mesh*, uint32_t> geometryOf;
  for (uint32_t g = 0; g < world.world->geometryCount(); ++g) geometryOf.emplace(&world.world->mesh(g), g);

  std::vector<trace::ShapeInput> shapes;
  std::vector<trace::PartInput> parts;
  std::vector<trace::PlacementInput> placements;
  std::vector<std::shared_ptr<geometry::Mesh>> boundaryOf;  // by medium
  std::vector<uint32_t> placementOf;
  std::vector<bool> needsShading;
  std::vector<float> filterWidths;
  Aggregates aggregates(tools.aggregates, interiorsOf(*world.materials));
  for (const uint32_t k : filled) {
    const uint32_t kind = flat->placements[k].kind, shape = flat->kinds[kind].shape;
    const scene::Primitive& p = *flat->shapes[shape].primitive;
    const geometry::Mesh& mesh = *meshes[shape];
    const auto geometry = geometryOf.find(&mesh);
    const auto instance = instanceOf.find(k);
    if (mesh.isStrand() || mesh.indices.empty() || geometry == geometryOf.end() || instance == instanceOf.end()) {
      if (mesh.isStrand())
        tools.diagnostics.warning("MEDIUM-OPEN", p.pos, "'" + p.name() + "' encloses no space for its medium",
                                  "it is left out", "curves and points have no inside");
      continue;
    }
    std::string name = flat->nameOf(k);
    if (name.empty()) name = p.name();
    const uint32_t visibility = aggregates.visibilityOf(flat->attributes[kind], flat->kinds[kind].visibility, name);
    if (!visibility) continue;
    const uint32_t index = uint32_t(media->media.size());
    shade::SpaceMedium& m = media->media.emplace_back();
    m.name = std::move(name);
    m.instance = instance->second;
    m.geometry = geometry->second;
    m.visibility = visibility;
    constexpr uint32_t kShadows = trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
    media->areShadowsOthers |= !(visibility & trace::kSeenByIndirect) != !(visibility & kShadows);
    m.side = signedVolume(mesh) < 0 ? -1.f : 1.f;
    const uint32_t material = world.placements[kind].material;
    const shade::Program& program = world.materials->program((*world.materials)[material].program);
    m.mayEmit = program.mediumFlags & kMediumMayEmit;
    media->mayEmit |= m.mayEmit;
    filterWidths.push_back(0);
    if (const scene::OtherPrimitive* volume = requestOf(p)) {
      Fields fields(p, *volume, tools);
      fields.read(m);
      filterWidths.back() = fields.filterWidth();
    }
    const shade::MaterialSet::Extinction& e = world.materials->extinction(material);
    m.isProduct = e.isProduct;
    m.towardsLights = e.towardsLights;
    std::copy_n(e.factor, 3, m.factor);
    for (float& f : m.factor) f = f > 0 && f < 1e30f ? f : 0.f;
    const auto take = [&](const std::string& name, const volume::MediumField*& field) {
      if (name.empty()) return;
      const auto it = m.fields.find(name);
      if (it != m.fields.end())
        field = &it->second;
      else
        m.isProduct = false;  // a primvar of the object, or nothing
    };
    take(e.number, m.number);
    take(e.color, m.color);
    m.extinctionByBounce = e.extinctionByBounce;
    m.contributionByBounce = e.contributionByBounce;
    media->isSimilar |= e.extinctionByBounce < 1 || e.contributionByBounce < 1;
    std::shared_ptr<geometry::Mesh> boundary = meshes[shape];
    for (int c = 0; c < 3; ++c) {
      m.low[c] = float(mesh.bounds.min[c]);
      m.high[c] = float(mesh.bounds.max[c]);
    }
    if (requestOf(p)) setMotion(e, p, tools, m);
    if (m.isCarried) boundary = grown(mesh, m.farthest);
    float low[3], high[3];
    int cells[3] = {1, 1, 1};
    for (int c = 0; c < 3; ++c) {
      low[c] = m.low[c] - m.farthest[c];
      high[c] = m.high[c] + m.farthest[c];
    }
    const bool isOne = m.isProduct && !m.number && !m.color && !m.isCarried;
    if (!isOne) cellsOf(low, high, kCells, cells);
    m.majorants = volume::Majorants(low, high, cells);
    needsShading.push_back(!m.isProduct);
    media->ofInstance.emplace(m.instance, index);

    boundaryOf.push_back(std::move(boundary));
    placementOf.push_back(k);
    if (world.world->instance(m.instance).keyCount < 2 && isBox(mesh)) media->boxes.push_back(index);
  }
  aggregates.tell(tools.diagnostics);
  if (media->media.empty()) return nullptr;
  // many boxes are found faster by a hierarchy
  if (media->boxes.size() > shade::SpaceMedia::kMostBoxes) media->boxes.clear();
  for (uint32_t index = 0; index < media->media.size(); ++index) {
    if (std::find(media->boxes.begin(), media->boxes.end(), index) != media->boxes.end()) continue;
    media->ofBoundary.push_back(index);
    trace::PartInput part;
    part.key = index + 1;
    part.instanced = true;  // the mesh stays where it is: others have it too
    part.shapes = {uint32_t(shapes.size())};
    trace::PlacementInput place;
    place.part = uint32_t(parts.size());
    place.toRender = flat->toRender(placementOf[index]);
    placements.push_back(std::move(place));
    parts.push_back(part);
    trace::ShapeInput input;
    input.key = index + 1;
    input.mesh = std::move(boundaryOf[index]);
    shapes.push_back(std::move(input));
  }
  trace::BuildOptions options;
  options.shutterOpen = tools.camera.shutterOpen;
  options.shutterClose = tools.camera.shutterClose;
  options.watertight = true;
  trace::BuildCounters counters;
  if (!parts.empty())
    media->boundaries =
        trace::World::build(std::move(shapes), std::move(parts), std::move(placements), options, nullptr, counters);

  media->areEven =
      std::all_of(media->media.begin(), media->media.end(), [](const shade::SpaceMedium& m) { return m.isEven(); });
  made_ = media;
  use(world);
  for (uint32_t i = 0; i < media->media.size(); ++i) {
    shade::SpaceMedium& m = media->media[i];
    if (needsShading[i])
      boundByShading(m, i, world, tools.stop);
    else
      boundByFields(m);
    const trace::Instance& instance = world.world->instance(m.instance);
    const float said = world.materials->extinction(world.placements[instance.info].material).most;
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = m.low[k] - m.farthest[k];
      high[k] = m.high[k] + m.farthest[k];
    }
    const float scale = world.spaceOf(m.instance, m.geometry).scale;
    setLevels(m, filterWidths[i], scale > 0 ? 1 / scale : 0);
    const auto limit = [said](volume::Majorants& bounds) {
      for (size_t cell = 0; said >= 0 && cell < bounds.count(); ++cell) bounds[cell] = std::min(bounds[cell], said);
    };
    limit(m.majorants);
    for (shade::SpaceMedium::Level& level : m.levels) limit(level.majorants);
    if (!m.mayEmit) continue;
    findEmission(m, i, world, low, high, tools.stop);
  }
  if (tools.stop && tools.stop->load(std::memory_order_relaxed)) inputs_ = {};  // not all of it has been looked at
  return made_;
}

void SpaceMediaStage::use(shade::ShadingWorld& world) const {
  world.space = made_;
  if (!made_) return;
  for (const shade::SpaceMedium& m : made_->media)
    for (const auto& [name, field] : m.fields) {
      uint32_t& width = world.primvarWidths[name];
      width = std::max(width, uint32_t(field.components()));
    }
}

}  // namespace kinora::render
