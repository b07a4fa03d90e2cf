#include "render/world_build.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "base/memory.h"
#include "image/colors.h"
#include "render/camera_attributes.h"
#include "render/detail.h"
#include "render/filters.h"
#include "render/ies_profiles.h"
#include "render/legacy_lights.h"
#include "render/space_names.h"
#include "render/surfaces.h"
#include "sampling/sample_table.h"
#include "shade/shader_scene.h"
#include "simd/dispatch.h"
#include "texture/texture_system.h"
#include "volume/volume_system.h"

namespace kinora::render {

namespace {

// Bytes of the geometry cache: what is said of it, and what memory is left for.
uint64_t geometryCacheOf(const scene::Scene& scene, const Settings& settings) {
  constexpr uint64_t kLeast = 16 << 20, kUsual = 1 << 30;
  const uint64_t said = geometryCacheSaid(scene, settings), wanted = said ? said : kUsual;
  return Memory::limit() ? std::min(wanted, std::max(kLeast, Memory::left() / 4)) : wanted;
}

// Of grids of volumes that lie in memory, likewise; 0: all of them. What does not fit lies in a file.
uint64_t volumeCacheOf(const scene::Scene& scene, const Settings& settings) {
  constexpr uint64_t kLeast = 64 << 20;
  const int own = scene.options.getInt("limits:brickmemory", 0);
  if (settings.volumeCacheBytes) return settings.volumeCacheBytes;
  if (own > 0) return uint64_t(own) << 10;
  return Memory::limit() ? std::max(kLeast, Memory::left() / 2) : 0;
}

// Triangles are halved by their middles until few are together.
void splitToCells(std::vector<Imath::Box3f>& triangles, std::vector<Imath::Box3d>& cells) {
  constexpr size_t kLeast = 32, kCells = 64;
  const size_t together = std::max(kLeast, triangles.size() / kCells);
  std::vector<std::pair<size_t, size_t>> runs{{0, triangles.size()}};
  while (!runs.empty()) {
    const auto [first, last] = runs.back();
    runs.pop_back();
    Imath::Box3f all, middles;
    for (size_t i = first; i < last; ++i) {
      all.extendBy(triangles[i]);
      middles.extendBy(triangles[i].center());
    }
    if (last - first <= together) {
      if (first < last) cells.push_back({Imath::V3d(all.min), Imath::V3d(all.max)});
      continue;
    }
    const auto axis = int(middles.majorAxis());
    const size_t half = first + (last - first) / 2;
    std::nth_element(
        triangles.begin() + long(first), triangles.begin() + long(half), triangles.begin() + long(last),
        [&](const Imath::Box3f& a, const Imath::Box3f& b) { return a.center()[axis] < b.center()[axis]; });
    runs.emplace_back(first, half);
    runs.emplace_back(half, last);
  }
}

bool isSet(const scene::Scene& scene, const char* ofHider) {
  return !scene.hider || scene.hider->params.getInt(ofHider, 1) != 0;
}

}  // namespace

uint64_t geometryCacheSaid(const scene::Scene& scene, const Settings& settings) {
  const int own = scene.options.getInt("limits:geocachememory", 0);
  return settings.geometryCacheBytes ? settings.geometryCacheBytes : own > 0 ? uint64_t(own) << 10 : 0;
}

WorldBuilder::WorldBuilder(Registry& registry, Diagnostics& diagnostics, const Settings& settings)
    : registry_(registry),
      diagnostics_(diagnostics),
      settings_(settings),
      textures_(std::make_unique<TextureSystem>(diagnostics, &contents_)),
      host_(diagnostics, textures_.get()),
      shaders_(diagnostics, &contents_) {
  width_ = settings.width ? settings.width : bestWidth();
  if (width_ == 16 && !cpuHasAvx512()) width_ = 8;  // sixteen lanes run as two of eight: the same bits
  if (settings.textureCacheBytes) textures_->setCacheLimit(settings.textureCacheBytes);
  textures_->setLevelFolder(settings.textureFolder);
}

WorldBuilder::~WorldBuilder() = default;

void WorldBuilder::forget() {
  forgetPlugins();
  interiors_.forget();
  flat_ = nullptr;
  meshes_.forget();
  traced_.forget();
}

void WorldBuilder::forgetPlugins() {
  shading_ = nullptr;
  ofCamera_ = {};
  camera_ = {};
  materials_.forget();
  lights_.forget();
  displacement_.forget();
  lightSurfaces_.forget();
  if (meshes_.forgetLevelled()) traced_.forget();
  media_.forget();
}

// The scene's own path, where '@' is the command line's, then the command line's. What the scene names relative to
// its folder is looked for there too: those folders are on the command line's path.
std::vector<std::string> WorldBuilder::searchPath(const scene::Scene& scene, const std::string& kind) const {
  const std::vector<std::string>& given = kind == "shader" ? settings_.shaderPath : settings_.texturePath;
  std::vector<std::string> path;
  const auto add = [&](const std::string& directory) {
    if (std::find(path.begin(), path.end(), directory) == path.end()) path.push_back(directory);
  };
  const std::string own = scene.options.getString("searchpath:" + kind, "");
  for (size_t at = 0; at < own.size();) {
    const size_t colon = std::min(own.find(':', at), own.size());
    const std::string part = own.substr(at, colon - at);
    at = colon + 1;
    if (part.empty() || part == "&") continue;
    if (part == "@") {
      for (const std::string& d : given) add(d);
      continue;
    }
    add(part);
    if (part[0] != '/')
      for (const std::string& d : given) add(d + "/" + part);
  }
  for (const std::string& d : given) add(d);
  return path;
}

bool WorldBuilder::haveFilesChanged() {
  return contents_.hasChanged([&](const FileContents::Entry& lacking) -> std::string {
    std::string place;
    if (lacking.kind == "texture") place = textures_->find(lacking.name);
    if (lacking.kind == "volume") place = volumes_->find(lacking.name);
    if (lacking.kind == "light profile") place = placeOfProfile(lacking.name, texturePath_);
    // one that is there and cannot be read is looked at once
    std::string& before = placesOfLacking_[lacking.kind + " " + lacking.name];
    return std::exchange(before, place) == place ? "" : place;
  });
}

bool WorldBuilder::openTextures(const scene::Scene& scene, Statistics& statistics) {
  std::vector<std::string> path = searchPath(scene, "texture");
  const bool isOther = !isOpen_ || path != texturePath_ || haveFilesChanged();
  if (isOther && isOpen_) {
    forgetPlugins();  // before the images that they point to
    contents_.forgetAll();
    textures_ = std::make_unique<TextureSystem>(diagnostics_, &contents_);
    host_.setTextures(textures_.get());
    if (settings_.textureCacheBytes) textures_->setCacheLimit(settings_.textureCacheBytes);
    textures_->setLevelFolder(settings_.textureFolder);
  }
  if (isOther)
    volumes_ = std::make_unique<VolumeSystem>(diagnostics_, settings_.volumeReader, &contents_,
                                              volumeCacheOf(scene, settings_));
  texturePath_ = std::move(path);
  isOpen_ = true;
  contents_.begin();
  if (image::Colors::ofEnvironment().isManaged())
    contents_.use("colour configuration", "OCIO", {std::string(std::getenv("OCIO"))});
  textures_->setSearchPath(texturePath_);
  volumes_->setSearchPath(texturePath_);
  if (isOther) ++statistics.rebuilt.textures;
  return isOther;
}

bool WorldBuilder::buildCamera(const scene::Scene& scene, Statistics& statistics) {
  const Digest digest = cameraDigestOf(scene);
  if (digest == ofCamera_) {
    contents_.again(filesOfCamera_);
    return true;
  }
  ofCamera_ = {};
  filesOfCamera_.clear();
  const FileContents::Listening listening(contents_, filesOfCamera_);
  std::optional<CameraState> made = makeCamera(scene, settings_, registry_, host(), width_, diagnostics_);
  if (!made) return false;
  camera_ = std::move(*made);
  ofCamera_ = digest;
  ++statistics.rebuilt.cameras;
  return true;
}

RenderSpace WorldBuilder::renderSpace() const {
  return {{camera_.origin[0], camera_.origin[1], camera_.origin[2]},
          {camera_.worldToCamera.inverse().translation(), camera_.pixelAngle, camera_.pixelSize, camera_.middle(),
           camera_.worldToCamera}};
}

void WorldBuilder::flattenScene(const scene::Scene& scene, const std::set<uint32_t>& emitters, Rebuilt& rebuilt) {
  const RenderSpace space = renderSpace();
  if (flat_ && flat_->isOf(scene, space, emitters)) return;
  const auto boundsMedia = [&](const scene::Attributes* a) {
    return fillsSpace(a, registry_, diagnostics_) || !aggregatesInside(a, registry_, diagnostics_).empty();
  };
  flat_ = flatten(scene, space, emitters, boundsMedia, settings_.stop, diagnostics_);
  ++rebuilt.flattened;
}

// What of the scene shading asks for itself.
void WorldBuilder::setScene(const scene::Scene& scene, shade::ShadingWorld& w) {
  w.width = width_;
  w.textures = textures_.get();
  w.volumes = volumes_.get();
  w.diagnostics = &diagnostics_;
  w.samples = sobolTable();
  describeGeometries(scene, camera_.middle(), *flat_, meshes_.all(), isSet(scene, "geomShadowTermBias"), w);
  describePlacements(*flat_, w);
  describeWalks(*flat_, meshes_.all(), w);
  describeSpaces(scene, camera_, w);
  warnOfUnknownSpaces(*flat_, w, diagnostics_);
  if (w.materials->shaderUses().empty()) return;
  w.shaders = std::make_shared<shade::ShaderScene>(diagnostics_);
  w.shaders->ofPlacement = flat_->attributes;
  w.shaders->camera = cameraAttributes(scene, camera_);
}

// In render space. What is not drawn at the size that it is seen is not met.
DelayedBounds WorldBuilder::boundsOfDelayed(const scene::Scene& scene, const Delayed& delayed) {
  DelayedBounds out;
  out.firstInstance = delayed.firstInstance;
  const View view{camera_.worldToCamera.inverse().translation(), camera_.pixelAngle, camera_.pixelSize,
                  camera_.middle(), camera_.worldToCamera};
  const double relative = double(scene.options.getFloat("detail:relative", 1));
  const auto inRender = [&](const Imath::Box3d& box) {
    trace::UnreadBounds::Box b;
    for (int k = 0; k < 3; ++k) {
      b.lower[k] = float(box.min[k] - camera_.origin[k]);
      b.upper[k] = float(box.max[k] - camera_.origin[k]);
    }
    return b;
  };
  const auto isDrawn = [&](const Delayed::Bound& b) {
    return render::isDrawn(b.attributes.get(), {}, view, relative);
  };
  for (const Delayed::Bound& b : delayed.all)
    if (isDrawn(b)) out.all.push_back(inRender(b.box));
  std::vector<trace::UnreadBounds::Box> unread;
  unreadPlaces_.clear();
  for (uint32_t k = 0; k < delayed.unread.size(); ++k) {
    const Delayed::Bound& bound = delayed.unread[k];
    if (!isDrawn(bound)) continue;
    const auto add = [&](const Imath::Box3d& box) {
      unread.push_back(inRender(box));
      unreadPlaces_.push_back(k);
    };
    if (!bound.cells) add(bound.box);
    for (size_t i = 0; bound.cells && i < bound.cells->size(); ++i) add((*bound.cells)[i]);
  }
  if (!unread.empty()) out.unread = std::make_shared<const trace::UnreadBounds>(std::move(unread));
  return out;
}

std::vector<uint32_t> WorldBuilder::metUnread() const {
  std::vector<uint32_t> out;
  if (const trace::UnreadBounds* unread = shading_->world->unread())
    for (const uint32_t k : unread->noted())
      if (out.empty() || out.back() != unreadPlaces_[k]) out.push_back(unreadPlaces_[k]);
  return out;
}

void WorldBuilder::findBytes(std::map<uint32_t, uint64_t>& ofInstances) const {
  constexpr uint64_t kOfTriangle = 65, kOfStrand = 116;  // of Embree's hierarchies, as docs/performance.md has them
  const std::vector<const geometry::Mesh*> meshes = meshes_.all();
  std::set<uint32_t> counted;
  for (uint32_t k = 0; k < flat_->placements.size(); ++k) {
    const auto bytes = ofInstances.find(flat_->outermostOf(k));
    if (bytes == ofInstances.end()) continue;
    bytes->second += sizeof(FlatScene::Placement) + sizeof(trace::Instance) + sizeof(trace::Affine);
    const uint32_t part = flat_->partOf(k);
    if (!counted.insert(part).second) continue;
    for (const uint32_t s : flat_->parts[part].shapes)
      bytes->second +=
          meshes[s]->bytes() + meshes[s]->primitiveCount() * (meshes[s]->isStrand() ? kOfStrand : kOfTriangle);
  }
}

void WorldBuilder::findCells(std::map<uint32_t, std::vector<Imath::Box3d>>& ofInstances) const {
  const std::vector<trace::ShapeInput> shapes = meshes_.shapes();
  std::map<uint32_t, std::vector<uint32_t>> placements;
  for (uint32_t k = 0; k < flat_->placements.size(); ++k)
    if (const uint32_t instance = flat_->outermostOf(k); ofInstances.contains(instance))
      placements[instance].push_back(k);
  const Imath::V3d origin(camera_.origin[0], camera_.origin[1], camera_.origin[2]);
  const auto find = [&](const std::vector<uint32_t>& placed, std::vector<Imath::Box3d>& cells) {
    uint64_t count = 0;
    for (const uint32_t k : placed)
      for (const uint32_t s : flat_->parts[flat_->partOf(k)].shapes) count += shapes[s].mesh->triangleCount();
    constexpr uint64_t kMost = 1 << 26, kApart = 1 << 18;
    if (count > kMost) return;
    const auto step = size_t(3 * (count / kApart + 1));  // neighbours in a list are mostly neighbours in space
    std::vector<Imath::Box3f> triangles;                 // in render space
    for (const uint32_t k : placed) {
      scene::Matrix m;
      if (flat_->memberOf(k).solid != trace::kNoSolid || !flat_->stillToRender(k, m)) return;
      for (const uint32_t s : flat_->parts[flat_->partOf(k)].shapes) {
        const geometry::Mesh& mesh = *shapes[s].mesh;
        if (shapes[s].user || mesh.isStrand() || mesh.keyCount() > 1 || flat_->shapes[s].boundsMedia) return;
        const scene::Matrix toRender = scene::Matrix().setTranslation(mesh.origin) * m;
        for (size_t i = 0; i < mesh.indices.size(); i += step) {
          Imath::Box3f box;
          for (size_t c = i; c < std::min(i + step, mesh.indices.size()); ++c) {
            const Imath::V3f p(Imath::V3d(mesh.points[mesh.indices[c]]) * toRender);
            if (!std::isfinite(p.x + p.y + p.z)) return;
            box.extendBy(p);
          }
          triangles.push_back(box);
        }
      }
    }
    Imath::Box3f all;
    for (const Imath::Box3f& b : triangles) all.extendBy(b);
    if (triangles.empty()) return;
    splitToCells(triangles, cells);
    // rays come into the space of an object in floats
    const float size = std::max({all.size().x, all.size().y, all.size().z, all.min.length(), all.max.length()});
    const Imath::V3d more(4e-6 * double(size));
    for (Imath::Box3d& c : cells) c = {c.min - more + origin, c.max + more + origin};
  };
  std::vector<std::pair<const uint32_t, std::vector<Imath::Box3d>>*> list;
  for (auto& entry : ofInstances) list.push_back(&entry);
  tbb::parallel_for(size_t(0), list.size(), [&](size_t i) { find(placements[list[i]->first], list[i]->second); });
  std::erase_if(ofInstances, [](const auto& entry) { return entry.second.empty(); });
}

void WorldBuilder::findBounds(std::map<uint32_t, Imath::Box3d>& ofInstances) const {
  const std::vector<const geometry::Mesh*> meshes = meshes_.all();
  for (uint32_t k = 0; k < flat_->placements.size(); ++k) {
    const auto box = ofInstances.find(flat_->outermostOf(k));
    if (box == ofInstances.end()) continue;
    const scene::Transform toRender = flat_->toRender(k);
    for (const uint32_t s : flat_->parts[flat_->partOf(k)].shapes)
      for (const scene::Matrix& m : toRender.matrices) {
        const scene::Matrix toWorld =
            scene::Matrix().setTranslation(meshes[s]->origin) * m *
            scene::Matrix().setTranslation(Imath::V3d(camera_.origin[0], camera_.origin[1], camera_.origin[2]));
        for (const Imath::V3f& p : meshes[s]->points) box->second.extendBy(Imath::V3d(p) * toWorld);
      }
  }
}

bool WorldBuilder::buildWorld(const scene::Scene& said, const Delayed& delayed,
                              const std::shared_ptr<const film::LightPaths>& paths,
                              const std::vector<SetAsker>& askers, const AggregateChoice& aggregates,
                              Statistics& statistics) {
  const auto start = std::chrono::steady_clock::now();
  Rebuilt& rebuilt = statistics.rebuilt;
  const scene::Scene& scene = interiors_.addTo(said, registry_, diagnostics_);
  const LightsToRender rendered = lightsToRender(scene, registry_, diagnostics_);
  const std::vector<scene::Light>& sources = rendered.lights;
  flattenScene(scene, rendered.shapes, rebuilt);
  displacement_.cache().setLimit(geometryCacheOf(scene, settings_));
  const Displacement::Tools moving{scene,     camera_,  registry_,     diagnostics_, *textures_, *volumes_,
                                   contents_, shaders_, shadersInUse_, paths,        width_};
  displacement_.begin(*flat_, moving);
  const bool isMade = meshes_.make(*flat_, camera_, displacement_, settings_.stop, diagnostics_, rebuilt);
  displacement_.end();
  if (!isMade) return false;
  const LightSurfaces::ByLight surfaces = lightSurfaces_.make(sources, moving, renderSpace(), settings_.stop);
  if (settings_.stop && settings_.stop->load()) return false;

  auto next = std::make_unique<shade::ShadingWorld>();
  next->paths = paths.get();
  next->placements = flat_->infos;
  next->objectSpaces = flat_->spaces;
  next->placementName = [flat = flat_](uint32_t placement) { return flat->nameOf(placement); };
  next->materials =
      materials_.make(*flat_,
                      {registry_, diagnostics_, *textures_, contents_, shaders_, shadersInUse_, paths, width_,
                       sources, scene.cameras.empty() ? std::array<float, 2>{} : scene.cameras[0].clipping,
                       !scene.integrator && areLightsClassic(scene)},
                      next->placements, rebuilt);
  Sight sight = sightOf(*flat_, *next->materials, askers, shadowSubsets(sources), next->placements,
                        delayed.unread.empty(), diagnostics_);
  for (size_t k = 0; k < next->placements.size(); ++k)  // nothing that a ray would hit
    if (next->materials->fillsSpace(next->placements[k].material) || isVolume(*flat_, k)) sight.ofKind[k] = 0;
  compareShadows(*flat_, *next->materials, sight, next->placements);
  next->areShadowsUnseen = sight.areShadowsUnseen;
  next->world = traced_.make(flat_, meshes_, sight, camera_, !isSet(scene, "jitter"), boundsOfDelayed(scene, delayed),
                             statistics, diagnostics_);
  next->traceSets = std::move(sight.sets);
  next->setsByText = std::move(sight.byText);
  setScene(scene, *next);
  const LinkSets links = linkObjects(scene, rendered, *flat_, next->placements);
  next->fillTables();
  media_.make(flat_, meshes_, *next,
              {{camera_, registry_, host(), *volumes_, diagnostics_},
               contents_,
               settings_.stop,
               aggregates,
               sight.subsetsOfKind});
  next->lights = lights_.make(scene, rendered, links, *flat_,
                              {registry_, diagnostics_, contents_, texturePath_, host(), camera_, *paths,
                               sight.ofLights, surfaces, sight.areShadowsOthers},
                              *next, rebuilt);
  count(scene, *next, statistics);
  shading_ = std::move(next);
  statistics.buildSeconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return true;
}

void WorldBuilder::countVolumes(Statistics& statistics) const {
  const volume::VoxelStore::Counts c = volumes_->store().counts();
  statistics.volumes = {volumes_->store().limit(), c.memoryBytes, c.fileBytes, c.mostBytes, c.wentOut};
}

void WorldBuilder::countLevels(Statistics& statistics) const {
  GeometryStatistics& g = statistics.geometry;
  const LevelCounters& from = displacement_.levelCounters();
  const trace::GeometryCache::Counts cache = displacement_.cache().counts();
  g.whole = meshes_.levelledQuads();
  g.found = from.found;
  g.passed = from.passed;
  g.vertices = from.vertices;
  g.seconds = double(from.nanoseconds) * 1e-9;
  g.limit = displacement_.cache().limit();
  g.bytes = cache.bytes;
  g.mostBytes = cache.mostBytes;
  g.made = cache.made;
  g.again = cache.again;
  g.twice = cache.twice;
  g.evicted = cache.evicted;
  for (size_t level = 0; level < g.micropolygons.size(); ++level)
    for (size_t kind = 0; kind < 3; ++kind) g.micropolygons[level][kind] = from.micropolygons[level][kind];
}

void WorldBuilder::count(const scene::Scene& scene, const shade::ShadingWorld& w, Statistics& statistics) {
  const shade::MaterialSet& materials = *w.materials;
  statistics.lights = w.lights->size();
  statistics.primitives = meshes_.size();
  statistics.instances = flat_->placements.size();
  statistics.triangles = w.world->triangleCount();
  statistics.materials = materials.size();
  statistics.programs = materials.programCount();
  statistics.shaders.clear();
  for (const shade::ShaderUse* use : materials.shaderUses())
    statistics.shaders.push_back({use->name, materials.materialsOf(*use), 0, 0, 0, 0, 0, 0, {}});
  statistics.shadersCompiled = shaders_.compiled();
  statistics.shaderPrograms = shaders_.executables().size();
  statistics.shaderCompileSeconds = shaders_.compileSeconds();
  meshes_.setHeld(w.world->meshBytes());
  statistics.micropolygons = displacement_.micropolygons();
  statistics.displaceSeconds = displacement_.seconds();
  statistics.memory.clear();
  statistics.memory.push_back({"bvh (Embree)", trace::World::embreeBytes()});
  statistics.memory.push_back({"meshes", w.world->meshBytes()});
  if (const uint64_t levels = meshes_.levelledBytes()) statistics.memory.push_back({"patches", levels});
  statistics.memory.push_back({"scene description", scene.bytes()});
  statistics.memory.push_back({"materials", materials.bytes()});
  if (materials.shaderBytes()) statistics.memory.push_back({"shader programs", materials.shaderBytes()});
  statistics.memory.push_back(
      {"instances", flat_->placements.size() * sizeof(FlatScene::Placement) +
                        w.placements.size() * (sizeof(shade::PlacementInfo) + sizeof(FlatScene::Kind)) +
                        w.objectSpaces->size() * sizeof(shade::ObjectSpace) + w.world->placementBytes()});
}

}  // namespace kinora::render
