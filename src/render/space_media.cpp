#include "render/space_media.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "render/medium_bounds.h"
#include "render/world_lights.h"

namespace kinora::render {

namespace {

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

// Of a closed surface the integral of x_i n_j over its area is its volume where i = j, else 0, and that of n is 0; seams
// of unshared vertices do not matter. Only open surfaces of much symmetry pass as well.
bool isClosed(const geometry::Mesh& mesh) {
  double moments[3][3] = {}, whole = 0, extent = 0;
  Imath::V3d sum(0, 0, 0);
  const Imath::V3d center = 0.5 * (mesh.bounds.min + mesh.bounds.max) - mesh.origin;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const Imath::V3d a = Imath::V3d(mesh.points[mesh.indices[i]]) - center,
                     b = Imath::V3d(mesh.points[mesh.indices[i + 1]]) - center,
                     c = Imath::V3d(mesh.points[mesh.indices[i + 2]]) - center;
    const Imath::V3d area = 0.5 * (b - a).cross(c - a), at = (a + b + c) / 3;
    sum += area;
    whole += area.length();
    extent = std::max(extent, at.length());
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) moments[k][j] += at[k] * area[j];
  }
  constexpr double kTolerance = 1e-4;
  bool closed = sum.length() <= kTolerance * whole;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      closed &= std::fabs(moments[k][j] - (k == j ? moments[0][0] : 0)) <= kTolerance * whole * extent;
  return closed;
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

// Aggregates that surfaces have inside, by name, and which of them each kind has.
struct InteriorNames {
  std::vector<std::string> all;
  std::vector<std::vector<uint32_t>> ofKind;  // numbers of these

  InteriorNames(const FlatScene& flat, Registry& registry, Diagnostics& diagnostics) : ofKind(flat.kinds.size()) {
    const scene::Network* last = nullptr;  // neighbours are often of one material
    std::vector<uint32_t> inLast;
    for (size_t kind = 0; kind < flat.kinds.size(); ++kind) {
      const scene::Network* material = flat.attributes[kind] ? flat.attributes[kind]->bxdf.get() : nullptr;
      if (material && material != last) {
        last = material;
        inLast.clear();
        for (const std::string& name : aggregatesInside(flat.attributes[kind], registry, diagnostics)) {
          const auto at = std::find(all.begin(), all.end(), name);
          inLast.push_back(uint32_t(at - all.begin()));
          if (at == all.end()) all.push_back(name);
        }
      }
      if (material) ofKind[kind] = inLast;
    }
  }
};

// The mesh of what is bounded, where it is placed.
struct Boundary {
  std::shared_ptr<geometry::Mesh> mesh;
  uint32_t placement;
};

void warnOfOpen(const scene::Primitive& p, Diagnostics& diagnostics) {
  diagnostics.warning("MEDIUM-OPEN", p.pos, "'" + p.name() + "' is open: its surface encloses no space",
                      "where a ray meets it once, the medium begins or ends there",
                      "a mesh without holes, of one primitive");
}

// The surfaces that media are cut off by, where some are seen only inside of them.
void findInteriors(const FlatScene& flat, const Meshes& meshes, const InteriorNames& names, shade::SpaceMedia& media,
                   std::vector<Boundary>& boundaries, Diagnostics& diagnostics) {
  if (std::none_of(media.media.begin(), media.media.end(),
                   [](const shade::SpaceMedium& m) { return m.visibilityInside != 0; }))
    return;
  media.nameCount = uint32_t(names.all.size());
  std::map<const geometry::Mesh*, float> sideOf;
  for (uint32_t k = 0; k < flat.placements.size(); ++k) {
    const uint32_t kind = flat.placements[k].kind;
    if (names.ofKind[kind].empty()) continue;
    const uint32_t shape = flat.kinds[kind].shape;
    const scene::Primitive& p = *flat.shapes[shape].primitive;
    const geometry::Mesh& mesh = *meshes[shape];
    if (mesh.isStrand() || mesh.indices.empty()) {
      if (mesh.isStrand())
        diagnostics.warning("MEDIUM-OPEN", p.pos, "'" + p.name() + "' encloses no space for the volumes inside",
                            "there are none", "curves and points have no inside");
      continue;
    }
    if (flat.memberOf(k).solid != trace::kNoSolid) {
      diagnostics.warning("MEDIUM-SOLID", p.pos, "'" + p.name() + "' is a part of a solid, and has volumes inside",
                          "there are none", "a closed mesh of the solid's shape has them");
      continue;
    }
    const auto [side, isNew] = sideOf.try_emplace(&mesh, 1.f);
    if (isNew) {
      side->second = signedVolume(mesh) < 0 ? -1.f : 1.f;
      if (!isClosed(mesh)) warnOfOpen(p, diagnostics);
    }
    media.interiors.push_back({flat.kinds[kind].visibility, side->second, names.ofKind[kind]});
    boundaries.push_back({meshes[shape], k});
  }
}

// Adds the subsets of rays that a member of `subsets` is seen by, as far as rays of their kinds see it.
void addSubsets(const std::vector<shade::TraceSet>& sets, uint32_t subsets, uint32_t& visibility) {
  constexpr uint32_t kShadows = trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
  const uint32_t kinds = visibility &= trace::kSeenByCamera | trace::kSeenByIndirect | kShadows;
  for (const shade::TraceSet& set : sets) {
    if (kinds & trace::kSeenByIndirect) visibility |= subsets & (set.reflect | set.transmit);
    if (kinds & kShadows) visibility |= subsets & (set.opaqueShadow | set.clearShadow);
  }
}

// Sets what media and interiors have to say of which rays know of them, those of objects with these sets among them.
void compareSights(const std::vector<shade::TraceSet>& sets, shade::SpaceMedia& media) {
  const auto compare = [&](uint32_t visibility) {
    struct Seen {
      bool reflect, transmit, shadow;
      bool operator==(const Seen&) const = default;
    };
    const auto by = [visibility](const shade::TraceSet& set) {
      return Seen{(visibility & set.reflect) != 0, (visibility & set.transmit) != 0,
                  (visibility & (set.opaqueShadow | set.clearShadow)) != 0};
    };
    const Seen plain = by({});
    media.areShadowsOthers |= plain.shadow != plain.reflect;
    for (const shade::TraceSet& set : sets) {
      const Seen own = by(set);
      media.areShadowsOthers |= own.shadow != own.reflect || own.shadow != own.transmit;
      media.hasSubsets |= own != plain;
    }
  };
  for (const shade::SpaceMedium& m : media.media) {
    compare(m.visibility);
    compare(m.visibilityInside);
  }
  for (const shade::SpaceInterior& x : media.interiors) compare(x.visibility);
}

// The hierarchy of boundaries, but for the few that are boxes. By number: of media, and behind them of interiors.
void setBoundaries(shade::SpaceMedia& media, const FlatScene& flat, std::vector<Boundary> boundaries,
                   const CameraState& camera) {
  std::vector<trace::ShapeInput> shapes;
  std::vector<trace::PartInput> parts;
  std::vector<trace::PlacementInput> placements;
  // many boxes are found faster by a hierarchy
  if (media.boxes.size() > shade::SpaceMedia::kMostBoxes) media.boxes.clear();
  for (uint32_t index = 0; index < boundaries.size(); ++index) {
    if (std::find(media.boxes.begin(), media.boxes.end(), index) != media.boxes.end()) continue;
    media.ofBoundary.push_back(index);
    trace::PartInput part;
    part.key = index + 1;
    part.instanced = true;  // the mesh stays where it is: others have it too
    part.shapes = {uint32_t(shapes.size())};
    trace::PlacementInput place;
    place.part = uint32_t(parts.size());
    place.toRender = flat.toRender(boundaries[index].placement);
    placements.push_back(std::move(place));
    parts.push_back(part);
    trace::ShapeInput input;
    input.key = index + 1;
    input.mesh = std::move(boundaries[index].mesh);
    shapes.push_back(std::move(input));
  }
  trace::BuildOptions options;
  options.shutterOpen = camera.shutterOpen;
  options.shutterClose = camera.shutterClose;
  options.watertight = true;
  trace::BuildCounters counters;
  if (!parts.empty())
    media.boundaries =
        trace::World::build(std::move(shapes), std::move(parts), std::move(placements), options, nullptr, counters);
}

// All that tracking and the choice of lights want to know of a medium of the world.
void findBounds(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world, float filterWidth,
                const std::atomic<bool>* stop) {
  if (!m.isProduct)
    boundByShading(m, index, world, stop);
  else
    boundByFields(m);
  const trace::Instance& instance = world.world->instance(m.instance);
  const float said = world.materials->extinction(world.placements[instance.info].material).most;
  const float scale = world.spaceOf(m.instance, m.geometry).scale;
  setLevels(m, filterWidth, scale > 0 ? 1 / scale : 0);
  const auto limit = [said](volume::Majorants& bounds) {
    for (size_t cell = 0; said >= 0 && cell < bounds.count(); ++cell) bounds[cell] = std::min(bounds[cell], said);
  };
  limit(m.majorants);
  for (shade::SpaceMedium::Level& level : m.levels) limit(level.majorants);
  if (m.mayEmit) findEmission(m, index, world, stop);
}

}  // namespace

bool fillsSpace(const scene::Attributes* attributes, Registry& registry, Diagnostics& diagnostics) {
  if (!attributes || !attributes->bxdf || !attributes->bxdf->terminal) return false;
  const scene::Node& bxdf = *attributes->bxdf->terminal;
  const Descriptor* plugin = registry.find(Kind::Bxdf, bxdf.plugin, diagnostics, bxdf.pos);
  return plugin && plugin->flags & kBxdfFillsSpace;
}

bool isVolume(const FlatScene& flat, size_t kind) {
  return volumeRequestOf(*flat.shapeOf(flat.kinds[kind]).primitive) != nullptr;
}

std::shared_ptr<const shade::SpaceMedia> SpaceMediaStage::make(const std::shared_ptr<const FlatScene>& flat,
                                                               const Meshes& meshes, shade::ShadingWorld& world,
                                                               const Tools& tools) {
  Diagnostics& diagnostics = tools.volumes.diagnostics;
  Inputs inputs{flat, world.materials, world.world, tools.aggregates, tools.subsetsOfKind, world.traceSets};
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
    if (!isFilled[k] && volumeRequestOf(p))
      diagnostics.warning("MEDIUM-NONE", p.pos, "'" + p.name() + "' has a material that is no medium's",
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

  const auto subsetsOf = [&](uint32_t kind) { return tools.subsetsOfKind.empty() ? 0u : tools.subsetsOfKind[kind]; };
  std::vector<Boundary> boundaries;  // by medium
  std::vector<float> filterWidths;
  std::set<const geometry::Mesh*> looked;  // whether they are open
  InteriorNames interiors(*flat, tools.volumes.registry, diagnostics);
  Aggregates aggregates(tools.aggregates, interiors.all);
  for (const uint32_t k : filled) {
    const uint32_t kind = flat->placements[k].kind, shape = flat->kinds[kind].shape;
    const scene::Primitive& p = *flat->shapes[shape].primitive;
    const geometry::Mesh& mesh = *meshes[shape];
    const auto geometry = geometryOf.find(&mesh);
    const auto instance = instanceOf.find(k);
    if (mesh.isStrand() || mesh.indices.empty() || geometry == geometryOf.end() || instance == instanceOf.end()) {
      if (mesh.isStrand())
        diagnostics.warning("MEDIUM-OPEN", p.pos, "'" + p.name() + "' encloses no space for its medium",
                            "it is left out", "curves and points have no inside");
      continue;
    }
    if (flat->memberOf(k).solid != trace::kNoSolid) {
      diagnostics.warning("MEDIUM-SOLID", p.pos, "'" + p.name() + "' is a part of a solid, and has a medium inside",
                          "it is left out", "a medium in a closed mesh of the solid's shape");
      continue;
    }
    if (looked.insert(&mesh).second && !isClosed(mesh)) warnOfOpen(p, diagnostics);
    std::string name = flat->nameOf(k);
    if (name.empty()) name = p.name();
    AggregateSight sight = aggregates.sightOf(flat->attributes[kind], flat->kinds[kind].visibility, name);
    if (!(sight.everywhere | sight.inside)) continue;
    const uint32_t index = uint32_t(media->media.size());
    shade::SpaceMedium& m = media->media.emplace_back();
    m.name = std::move(name);
    m.instance = instance->second;
    m.geometry = geometry->second;
    m.visibility = sight.everywhere;
    m.visibilityInside = sight.inside;
    m.insideOf = std::move(sight.insideOf);
    for (uint32_t* seen : {&m.visibility, &m.visibilityInside}) addSubsets(world.traceSets, subsetsOf(kind), *seen);
    m.side = signedVolume(mesh) < 0 ? -1.f : 1.f;
    const uint32_t material = world.placements[kind].material;
    const shade::Program& program = world.materials->program((*world.materials)[material].program);
    m.mayEmit = program.mediumFlags & kMediumMayEmit;
    media->mayEmit |= m.mayEmit;
    filterWidths.push_back(0);
    if (volumeRequestOf(p)) filterWidths.back() = readVolumeFields(p, tools.volumes, m);
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
    if (volumeRequestOf(p)) setVolumeMotion(e, p, tools.volumes, m);
    if (m.isCarried) boundary = grown(mesh, m.farthest);
    makeBoundCells(m);
    media->ofInstance.emplace(m.instance, index);

    boundaries.push_back({std::move(boundary), k});
    if (world.world->instance(m.instance).keyCount < 2 && isBox(mesh)) media->boxes.push_back(index);
  }
  aggregates.tell(diagnostics);
  if (media->media.empty()) return nullptr;
  findInteriors(*flat, meshes, interiors, *media, boundaries, diagnostics);
  for (size_t i = 0; i < media->interiors.size(); ++i)
    addSubsets(world.traceSets, subsetsOf(flat->placements[boundaries[media->media.size() + i].placement].kind),
               media->interiors[i].visibility);
  compareSights(world.traceSets, *media);
  setBoundaries(*media, *flat, std::move(boundaries), tools.volumes.camera);
  media->areEven =
      std::all_of(media->media.begin(), media->media.end(), [](const shade::SpaceMedium& m) { return m.isEven(); });
  made_ = media;
  use(world);
  for (uint32_t i = 0; i < media->media.size(); ++i)
    findBounds(media->media[i], i, world, filterWidths[i], tools.stop);
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
