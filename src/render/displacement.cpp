#include "render/displacement.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <variant>

#include "base/memory.h"
#include "base/text.h"
#include "geometry/grade.h"
#include "geometry/refine.h"
#include "render/camera_attributes.h"
#include "render/matrix_scale.h"
#include "render/surfaces.h"
#include "render/thread_groups.h"
#include "sampling/sample_table.h"
#include "shade/shader_scene.h"

namespace kinora::render {

namespace {

constexpr uint32_t kVerticesAtOnce = 1024;  // of a context

const char* withoutSurface(const scene::Primitive& p) {
  if (std::holds_alternative<scene::Curves>(p.shape)) return "curves";
  if (std::holds_alternative<scene::Points>(p.shape)) return "points";
  return nullptr;
}

// Whether what a network computes may depend on the camera's or a named space: a plug-in says so, a shader may.
bool asksForSpaces(const scene::Network& network, const scene::Scene& scene) {
  const auto names = [&](const scene::NodePtr& n) {
    for (const scene::Parameter& p : n->params)
      for (const std::string& s : p.strings)
        if (s == "camera" || s == "Vn" || scene.coordinateSystems.contains(s)) return true;
    return false;
  };
  for (const scene::NodePtr& n : network.patterns)
    if (!n->plugin.starts_with("Pxr") || sameName(n->plugin, "PxrOSL") || names(n)) return true;
  return !network.terminal->plugin.starts_with("Pxr") || names(network.terminal);
}

// Whether lengths of a displacement are those of a space that does not follow each instance. Of shaders, which write P
// of the world, only what they do tells.
bool hasOuterLengths(const scene::Network& network, const scene::Scene& scene) {
  for (const scene::NodePtr& n : network.patterns)
    if (sameName(n->plugin, "PxrDispTransform")) {
      const std::string space = n->params.getString("dispScaleSpace", "object");
      if (space == "world" || space == "camera" || scene.coordinateSystems.contains(space)) return true;
    }
  return false;
}

// Patches of surfaces that are diced on demand are about so many micropolygons long, and such surfaces have at least so
// many triangles a patch: of cages that are fine to begin with no coarser grids could be made.
constexpr double kStepsOfPatch = 64;
constexpr uint64_t kLeastOfPatch = 128;
// All of a surface without a bound is diced once to find out where it is: no more than this.
constexpr uint64_t kMostWithoutBound = 200'000'000;
constexpr int kMostTries = 32;  // for so many
// Where levels are asked for: of patches that are single micropolygons the boxes overlap, and rays look into many.
constexpr uint64_t kLeastOfPatchAsked = 3;

// That a mesh would be cut into as it is at a key.
double trianglesOf(const geometry::Mesh& mesh, const geometry::DiceRate& rate, int key = 0) {
  double sum = 0;
  const Imath::V3f* const points = mesh.points.data() + size_t(key) * mesh.vertexCount;
  for (uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    const auto at = [&](int k) { return Imath::V3d(points[mesh.indices[3 * size_t(t) + size_t(k)]]); };
    const Imath::V3d a = at(0), b = at(1), c = at(2), d = (a + b + c) / 3;
    double edge = INFINITY;
    for (const Imath::V3d& p : {a, b, c, d}) edge = std::min(edge, rate.at(p + mesh.origin));
    sum += (b - a).cross(c - a).length() / (edge * edge);
  }
  return sum;
}

// What is has a vertex wherever it needs one.
bool isDicedByMaker(const scene::Primitive& p) {
  return !std::holds_alternative<scene::PolygonMesh>(p.shape) &&
         !std::holds_alternative<scene::OtherPrimitive>(p.shape);
}

std::string numberText(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

}  // namespace

void Displacement::begin(const FlatScene& flat, const Tools& tools) {
  listening_ = nullptr;
  flat_ = &flat;
  tools_ = std::make_unique<Tools>(tools);
  materialOf_.clear();
  const std::vector<Digest> before = std::move(digests_);
  ranges_.clear();
  digests_.clear();
  set_ = nullptr;
  const auto networkOf = [&](size_t shape) -> scene::NetworkPtr {
    const scene::AttributesPtr& a = flat.shapes[shape].attributes;
    const bool isMoved = a && a->displacement && a->displacement->terminal && a->getInt("trace:displacements", 1);
    return isMoved ? a->displacement : nullptr;
  };
  size_t first = 0;
  while (first < flat.shapes.size() && !networkOf(first)) ++first;
  if (first == flat.shapes.size()) return;

  // while these are held no other shader has their addresses
  const std::vector<std::shared_ptr<const shade::ShaderNode>> shadersBefore =
      std::exchange(shaders_, tools.shadersInUse);
  placementOf_.assign(flat.shapes.size(), 0);
  for (size_t p = flat.placements.size(); p-- > 0;)
    for (const uint32_t s : flat.parts[flat.partOf(uint32_t(p))].shapes) placementOf_[s] = uint32_t(p);
  Hasher around;
  around.digest(scene::digestOf(tools.scene.coordinateSystems));
  around.bytes(&tools.camera.worldToCamera, sizeof tools.camera.worldToCamera);
  const Digest spaces = around.result();

  auto set = std::make_shared<shade::MaterialSet>(tools.registry, tools.diagnostics, tools.textures, tools.width,
                                                  *tools.paths, tools.shaders);
  FileContents::Names files = std::move(files_);
  files_.clear();
  listening_ = std::make_unique<FileContents::Listening>(tools.contents, files_);
  materialOf_.assign(flat.shapes.size(), shade::MaterialSet::kNone);
  digests_.resize(flat.shapes.size());
  for (size_t s = first; s < flat.shapes.size(); ++s) {
    const scene::NetworkPtr network = networkOf(s);
    if (!network) continue;
    const scene::Primitive& p = *flat.shapes[s].primitive;
    if (const char* kind = withoutSurface(p)) {
      tools.diagnostics.warning("DISPLACEMENT-KIND", p.pos,
                                std::string(kind) + " have a displacement (node '" + network->terminal->handle + "')",
                                "they are drawn without it", "displacement moves surfaces");
      continue;
    }
    materialOf_[s] = set->addDisplacement(network);
    if (!moves(s)) continue;
    const scene::Attributes& a = *flat.shapes[s].attributes;
    Hasher h;
    h.bytes(tools.camera.origin, sizeof tools.camera.origin);
    h.digest(networks_.of(network));
    if (p.attributes && p.attributes->coordinateSystems) h.digest(scene::digestOf(*p.attributes->coordinateSystems));
    const auto addShader = [&](const scene::NodePtr& n) {
      const std::string name = shade::shaderNameOf(*n);
      h.word(reinterpret_cast<uintptr_t>(name.empty() ? nullptr : tools.shaders.find(name, n->pos).get()));
    };
    for (const scene::NodePtr& n : network->patterns) addShader(n);
    addShader(network->terminal);
    if (asksForSpaces(*network, tools.scene)) h.digest(spaces);
    h.digest(scene::digestOf(a.named));
    for (const auto* color : {&a.color, &a.opacity}) {
      h.word(color->has_value());
      if (*color) h.bytes((*color)->data(), sizeof **color);
    }
    h.bytes(&a.shadingRate, sizeof a.shadingRate);
    h.digest(scene::digestOf(toRenderOf(s, placementOf_[s])));
    digests_[s] = h.result();
  }
  networks_.forgetOthers();
  set->finish();
  set_ = std::move(set);
  tellOfScales();
  // shaders name textures while they run: what is kept has used them, and what another shape used is not known
  if (set_->shaderUses().empty()) return;
  if (digests_ == before)
    tools.contents.again(files);
  else
    forget();
}

// A surface is displaced once, where it stands first: instances of other sizes show the same, larger or smaller.
void Displacement::tellOfScales() {
  const size_t count = flat_->shapes.size();
  std::vector<char> isAsked(count, 0), isShader(count, 0);
  ranges_.assign(count, {});
  for (size_t s = 0; s < count; ++s)
    if (moves(s)) {
      isShader[s] = set_->program((*set_)[materialOf_[s]].program).isMovedByShader;
      isAsked[s] = isShader[s] || hasOuterLengths(*flat_->shapes[s].attributes->displacement, tools_->scene);
    }
  if (std::find(isAsked.begin(), isAsked.end(), 1) == isAsked.end()) return;
  for (uint32_t p = 0; p < flat_->placements.size(); ++p)
    for (const uint32_t s : flat_->parts[flat_->partOf(p)].shapes) {
      if (!isAsked[s]) continue;
      const double scale = scaleAt(s, p);
      ScaleRange& r = ranges_[s];
      if (r.most == 0 || scale < r.least) r.least = scale, r.smallest = p;
      if (r.most == 0 || scale > r.most) r.most = scale, r.largest = p;
    }
  for (size_t s = 0; s < count; ++s) {
    if (!(ranges_[s].most > 1.001 * ranges_[s].least))
      ranges_[s] = {};
    else if (!isShader[s])
      tellOfScale(s);
  }
}

// Surfaces are displaced in their own space, wherever their meshes end up.
scene::Transform Displacement::toRenderOf(size_t shape, uint32_t placement) const {
  const scene::Transform toRender = flat_->toRender(placement);
  const FlatScene::Shape& s = flat_->shapes[shape];
  return s.isBaked ? concat(s.primitive->toWorld, toRender) : toRender;
}

double Displacement::scaleAt(size_t shape, uint32_t placement) const {
  return scaleOf(toRenderOf(shape, placement).at(tools_->camera.middle()));
}

void Displacement::tellOfScale(size_t shape) const {
  const scene::Node& node = *flat_->shapes[shape].attributes->displacement->terminal;
  tools_->diagnostics.warning(
      "DISPLACEMENT-SCALE", node.pos,
      "displacement '" + node.handle + "' is measured in the world's lengths, and instances of " +
          flat_->shapes[shape].primitive->name() + " have scales from " + numberText(ranges_[shape].least) + " to " +
          numberText(ranges_[shape].most),
      "all are displaced as the first of them, which has " + numberText(scaleAt(shape, placementOf_[shape])),
      "measure it in the object's own lengths, or put what has another scale into an object of its own");
}

// A shader may reckon in any space. Some points are moved as if they belonged to the instance whose scale differs most
// from the first's: what is measured in the object's lengths goes as far there, in those.
void Displacement::checkScale(size_t shape, const std::shared_ptr<geometry::Mesh>& mesh,
                              const geometry::Micropolygons& grid, const std::vector<Imath::V3f>* offsets,
                              const std::atomic<bool>* stop) const {
  if (ranges_.empty() || !set_->program((*set_)[materialOf_[shape]].program).isMovedByShader) return;
  const ScaleRange& r = ranges_[shape];
  if (!(r.most > r.least)) return;
  const double first = scaleAt(shape, placementOf_[shape]);
  const uint32_t other = r.most * r.least > first * first ? r.largest : r.smallest;
  constexpr size_t kPoints = 500;
  geometry::Micropolygons some = grid;
  const size_t count = some.corner.size(), step = std::max<size_t>(1, count / kPoints);
  for (size_t v = 0; v < count; ++v)
    if (v % step) some.corner[v] = geometry::Micropolygons::kNone;
  const Shaded there = shade(shape, other, mesh, some, stop);
  const Shaded here = offsets ? Shaded() : shade(shape, placementOf_[shape], mesh, some, stop);
  if (stop && stop->load(std::memory_order_relaxed)) return;
  double own = 0, others = 0;
  for (size_t v = 0; v < count; v += step) {
    own += double((offsets ? *offsets : here.offsets)[v].length2());
    others += double(there.offsets[v].length2());
  }
  if (!(own > 0) || !(others > 0) || !std::isfinite(own + others)) return;
  if (std::abs(std::sqrt(others / own) - 1) > 0.1 * std::abs(first / scaleAt(shape, other) - 1)) tellOfScale(shape);
}

void Displacement::end() {
  flat_ = nullptr;
  listening_ = nullptr;
  tools_ = nullptr;
  set_ = nullptr;
  materialOf_.clear();
  ranges_.clear();
}

Digest Displacement::digestOf(size_t shape) const {
  if (!moves(shape)) return {};
  Hasher h;
  h.digest(digests_[shape]);
  h.word(generation_);
  return h.result();
}

// A world of one object where it stands in the scene, for places alone.
shade::ShadingWorld Displacement::worldOf(size_t shape, uint32_t placement,
                                          const std::shared_ptr<geometry::Mesh>& mesh) const {
  FlatScene alone;
  alone.shapes = {flat_->shapes[shape]};
  alone.shapes[0].isBaked = false;
  trace::PartInput part;
  part.shapes = {0};
  part.instanced = true;
  alone.parts = {part};
  uint32_t kind = flat_->placements[placement].kind;  // of the part's first shape
  while (flat_->kinds[kind].shape != shape) ++kind;
  alone.infos = {flat_->infos[kind]};
  alone.attributes = {flat_->shapes[shape].attributes.get()};

  shade::ShadingWorld w;
  trace::ShapeInput input;
  input.mesh = mesh;
  trace::BuildOptions options;
  options.shutterOpen = tools_->camera.shutterOpen;
  options.shutterClose = tools_->camera.shutterClose;
  options.placesOnly = true;
  trace::BuildCounters counters;
  trace::PlacementInput place;
  place.toRender = toRenderOf(shape, placement);
  w.world = trace::World::build({input}, alone.parts, {place}, options, nullptr, counters);
  w.materials = set_;
  w.placements = alone.infos;
  w.objectSpaces = std::make_shared<const std::vector<shade::ObjectSpace>>(
      1, shade::ObjectSpace::of(place.toRender.at(tools_->camera.middle())));
  w.placements[0].material = materialOf_[shape];
  w.isForPlaces = true;
  w.width = tools_->width;
  w.textures = &tools_->textures;
  w.volumes = &tools_->volumes;
  w.diagnostics = &tools_->diagnostics;
  w.samples = sobolTable();
  w.paths = tools_->paths.get();
  describeGeometries(tools_->scene, tools_->camera.middle(), alone, {mesh.get()}, false, w);
  describePlacements(alone, w);
  describeSpaces(tools_->scene, tools_->camera, w);
  if (!set_->shaderUses().empty()) {
    w.shaders = std::make_shared<shade::ShaderScene>(tools_->diagnostics);
    w.shaders->ofPlacement = alone.attributes;
    w.shaders->camera = cameraAttributes(tools_->scene, tools_->camera);
  }
  w.fillTables();
  return w;
}

Displacement::Shaded Displacement::shade(size_t shape, uint32_t placement,
                                         const std::shared_ptr<geometry::Mesh>& mesh,
                                         const geometry::Micropolygons& grid, const std::atomic<bool>* stop) const {
  Shaded all;
  all.offsets.assign(mesh->points.size(), Imath::V3f(0));
  if (set_->program((*set_)[materialOf_[shape]].program).isMovedByShader) all.normals = all.offsets;
  std::atomic<bool> hasNormals = false;
  const shade::ShadingWorld world = worldOf(shape, placement, mesh);
  const geometry::Primvar& normals = *mesh->find("N");
  const size_t keys = size_t(mesh->keyCount()), count = mesh->vertexCount;
  const float toRender = float(scaleAt(shape, placement));
  const size_t chunks = (count + kVerticesAtOnce - 1) / kVerticesAtOnce;
  ThreadGroups groups(world);
  const auto shadeChunk = [&](size_t chunk) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    const ThreadGroups::Use use(groups);
    Arena& arena = use.arena();
    const size_t key = chunk / chunks, begin = chunk % chunks * kVerticesAtOnce;
    const uint32_t room = padded(kVerticesAtOnce);
    uint32_t *vertex = arena.make<uint32_t>(room), *zero = arena.make<uint32_t>(room),
             *triangle = arena.make<uint32_t>(room), *number = arena.make<uint32_t>(room);
    const auto floatsOf = [&] { return arena.make<float>(room); };
    float *u = floatsOf(), *v = floatsOf(), *time = floatsOf(), *radius = floatsOf();
    float *P[3] = {floatsOf(), floatsOf(), floatsOf()}, *N[3] = {floatsOf(), floatsOf(), floatsOf()},
          *out[3] = {floatsOf(), floatsOf(), floatsOf()}, *turned[3] = {floatsOf(), floatsOf(), floatsOf()};
    uint32_t n = 0;
    for (size_t i = begin; i < std::min(count, begin + kVerticesAtOnce); ++i) {
      const uint32_t corner = grid.corner[i];
      if (corner == geometry::Micropolygons::kNone) continue;
      vertex[n] = number[n] = uint32_t(i);
      zero[n] = 0;
      triangle[n] = corner / 3;
      u[n] = corner % 3 == 1 ? 1.f : 0.f;
      v[n] = corner % 3 == 2 ? 1.f : 0.f;
      time[n] = keys > 1 ? float(key) / float(keys - 1) : 0.5f;
      radius[n] = 0.5f * grid.size[i] * toRender;
      const Imath::V3f& p = mesh->points[key * count + i];
      const float* normal = &normals.data[3 * ((mesh->movesWithKeys(normals) ? key * count : 0) + i)];
      for (int k = 0; k < 3; ++k) {
        P[k][n] = p[k] + float(mesh->origin[k]);
        N[k][n] = normal[k];
      }
      ++n;
    }
    if (!n) return;
    const SurfacePlaces places{zero, zero, triangle, u, v, time, radius, nullptr, number, zero};
    const bool isTurned = use.group().displace(n, places, P, N, out, turned);
    if (isTurned) hasNormals = true;
    for (uint32_t i = 0; i < n; ++i) {
      all.offsets[key * count + vertex[i]] = {out[0][i], out[1][i], out[2][i]};
      if (isTurned) all.normals[key * count + vertex[i]] = {turned[0][i], turned[1][i], turned[2][i]};
    }
  };
  // a thread that waits here must not begin another mesh: their memory would add up
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(size_t(0), chunks * keys, shadeChunk); });
  if (!hasNormals) all.normals.clear();
  return all;
}

void Displacement::apply(size_t shape, const geometry::DiceRate& rate, const std::atomic<bool>* stop,
                         geometry::Mesh& mesh, const Found& known) const {
  if (!mesh.triangleCount()) return;
  const auto start = std::chrono::steady_clock::now();
  using Rate = geometry::Primvar::Rate;
  const scene::Primitive& p = *flat_->shapes[shape].primitive;
  const bool isDiced = isDicedByMaker(p);
  const geometry::Primvar* normals = mesh.find("N");
  bool isByVertex = normals && normals->rate == Rate::PerVertex;
  for (const geometry::Primvar& v : mesh.primvars) isByVertex &= v.rate != Rate::PerCorner;
  if (stop && stop->load(std::memory_order_relaxed)) return;
  if (!isDiced && !known.triangles)
    if (std::optional<geometry::Mesh> even = geometry::graded(mesh, rate)) mesh = std::move(*even);
  if (!isDiced || mesh.triangleCount() > rate.maxTriangles / 4)
    if (const double wanted = known.triangles ? *known.triangles : trianglesOf(mesh, rate);
        wanted > 4.0 * rate.maxTriangles)
      tellOfCoarse(shape, wanted, rate.maxTriangles);
  if (!isDiced || !isByVertex) {
    geometry::DiceRate asItIs;
    mesh = geometry::refined(mesh, isDiced ? asItIs : rate);
  }
  MemoryHold working(MemoryUse::Meshes);
  working.add(mesh.bytes());
  auto base = std::make_shared<geometry::Mesh>(std::move(mesh));
  const geometry::Micropolygons grid(*base);
  Shaded shaded = shade(shape, placementOf_[shape], base, grid, stop);
  checkScale(shape, base, grid, &shaded.offsets, stop);
  mesh = std::move(*base);
  if (stop && stop->load(std::memory_order_relaxed)) return;
  const geometry::DisplacementResult result =
      geometry::displace(mesh, grid, std::move(shaded.offsets), shaded.normals);
  if (result.notFinite) {
    const scene::Node& node = *flat_->shapes[shape].attributes->displacement->terminal;
    tools_->diagnostics.warning("DISPLACEMENT-NOT-FINITE", node.pos,
                                "displacement '" + node.handle + "' moves " + std::to_string(result.notFinite) +
                                    " points of " + p.name() + " nowhere or too far, the first on face " +
                                    std::to_string(result.firstFace),
                                "these points stay where they are");
  }
  checkBound(shape, result.longest);
  uint32_t quads = 0;
  for (uint32_t t = 0; t < mesh.triangleCount(); ++t) quads += mesh.quadOf(t) == t;
  micropolygons_ += mesh.triangleCount() - quads;
  nanoseconds_ += uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
}

void Displacement::tellOfCoarse(size_t shape, double wanted, double made) const {
  const scene::Node& node = *flat_->shapes[shape].attributes->displacement->terminal;
  tools_->diagnostics.warning("DISPLACEMENT-COARSE", node.pos,
                              "displacement '" + node.handle + "' of " + flat_->shapes[shape].primitive->name() +
                                  " asks for " + numberText(wanted) + " triangles of micropolygons, and at most " +
                                  numberText(made) + " are made",
                              "they are " + numberText(std::sqrt(wanted / made)) + " times as long as they should be",
                              "a greater Attribute \"dice\" \"float micropolygonlength\" says what is wanted; with a "
                              "displacementbound and levels more are made; or leave out what is not seen of it");
}

double Displacement::boundOf(size_t shape, std::string& space, double& scale) const {
  const scene::Attributes& a = *flat_->shapes[shape].attributes;
  space = a.named.getString("displacementbound:coordinatesystem", "");
  if (space.empty()) space = a.named.getString("displacementbound:CoordinateSystem", "object");
  scale = 1;
  const double toWorld = scaleAt(shape, placementOf_[shape]);
  if (space == "world" || space == "camera") {
    scale = toWorld;
  } else if (const auto it = tools_->scene.coordinateSystems.find(space);
             it != tools_->scene.coordinateSystems.end()) {
    const double own = scaleOf(it->second.at(tools_->camera.middle()));
    if (own > 0) scale = toWorld / own;
  }
  return double(a.named.getFloat("displacementbound:sphere", 0));
}

// displacementbound says how far points may move; here all that move are drawn, and a bound that is too small is told,
// since it would cut holes elsewhere.
void Displacement::checkBound(size_t shape, double longest) const {
  const scene::Attributes& a = *flat_->shapes[shape].attributes;
  const scene::Parameter* sphere = a.named.find("displacementbound:sphere");
  if (!sphere) return;
  std::string space;
  double scale = 1;
  const double bound = boundOf(shape, space, scale);
  const double way = longest * scale;
  if (way <= bound * 1.0001) return;
  const scene::Node& node = *a.displacement->terminal;
  std::string what = "displacement '" + node.handle + "' moves points of " + flat_->shapes[shape].primitive->name() +
                     " by up to " + numberText(way) + " (" + space + "), displacementbound allows " +
                     numberText(bound);
  if (bound > 0) what += ": " + numberText(way / bound) + " times that";
  tools_->diagnostics.warning("DISPLACEMENT-BOUND", sphere->pos.line ? sphere->pos : node.pos, what,
                              "all of it is drawn", "a displacementbound of " + numberText(way) + " holds it");
}

bool Displacement::mayHaveLevels(size_t shape) const {
  // what nothing displaces may have no attributes
  return moves(shape) && flat_->shapes[shape].attributes->named.getInt("dice:levels", -1) != 0 &&
         !flat_->shapes[shape].boundsMedia && flat_->memberOf(placementOf_[shape]).solid == trace::kNoSolid;
}

std::shared_ptr<const LevelledSurface> Displacement::levelled(size_t shape, const geometry::DiceRate& rate,
                                                              double pixels, const std::atomic<bool>* stop,
                                                              geometry::Mesh& mesh, Found& found) const {
  if (mesh.isStrand() || !mesh.triangleCount()) return nullptr;
  const bool isAsked = flat_->shapes[shape].attributes->named.getInt("dice:levels", -1) > 0;
  const std::optional<geometry::Mesh> even = geometry::graded(mesh, rate);
  const geometry::Mesh& base = even ? *even : mesh;
  double wanted = trianglesOf(base, rate);
  // as faces are cut by what the first and the last key ask for
  if (base.keyCount() > 1) wanted = std::max(wanted, trianglesOf(base, rate, base.keyCount() - 1));
  const scene::Primitive& p = *flat_->shapes[shape].primitive;
  // polygons are the same faces again; where they are even no grading has to be made
  if (!even && std::holds_alternative<scene::PolygonMesh>(p.shape)) found.triangles = wanted;
  // makers of grids do not follow rates that differ so much over one of theirs
  const bool isNeeded = isAsked || (even && isDicedByMaker(p));
  if (!isNeeded && wanted < double(rate.maxTriangles)) return nullptr;
  std::string space;
  double scale = 1;
  const double bound = boundOf(shape, space, scale);
  double longer = 1;  // than asked for
  // Each try takes seconds on a large surface, and does not tell how much too fine it is once its patches have as many
  // steps as they can. Areas tell, but they count the finest place of each face for all of it.
  constexpr double kDoubt = 64;
  if (!(bound > 0)) longer = std::max(1.0, std::sqrt(wanted / double(kMostWithoutBound)) / kDoubt);
  geometry::DiceRate finest = rate, coarse = rate;
  finest.edgeLength = [&](const Imath::V3d& p) { return longer * rate.at(p); };
  coarse.edgeLength = [&](const Imath::V3d& p) { return kStepsOfPatch * longer * rate.at(p); };
  std::shared_ptr<geometry::Patches> patches;
  uint64_t triangles = 0, asked = 0;
  for (int tries = 1;; ++tries) {
    patches = std::make_shared<geometry::Patches>(geometry::refined(base, coarse), finest);
    if (rate.isStopped()) return nullptr;
    triangles = patches->triangles();
    asked = std::max(asked, triangles);
    if (bound > 0 || triangles <= kMostWithoutBound || patches->count() >= triangles || tries >= kMostTries) break;
    longer *= std::max(1.5, std::sqrt(double(triangles) / double(kMostWithoutBound)));
  }
  if (!isNeeded && (triangles < rate.maxTriangles || triangles < kLeastOfPatch * patches->count())) return nullptr;
  if (triangles < kLeastOfPatchAsked * patches->count()) {
    if (isAsked)
      tools_->diagnostics.info("DISPLACEMENT-LEVELS", p.pos,
                               p.name() + " is diced at once: its patches are hardly larger than micropolygons");
    return nullptr;
  }
  if (longer > 1 || wanted > 4 * double(triangles))
    tellOfCoarse(shape, std::max(wanted, double(asked)), double(triangles));
  const scene::Node& node = *flat_->shapes[shape].attributes->displacement->terminal;
  LevelledSurface::Setup setup;
  setup.patches = patches;
  setup.world = worldOf(shape, placementOf_[shape], patches->mesh());
  setup.world.placesByParameter = true;
  setup.attributes = flat_->shapes[shape].attributes;
  setup.paths = tools_->paths;
  setup.object = p.name();
  setup.displacement = node.handle;
  setup.pos = node.pos;
  setup.toRender = float(scaleAt(shape, placementOf_[shape]));
  if (bound > 0 && scale > 0) setup.bound = bound / scale;
  setup.pixels = float(pixels);
  setup.stop = stop;
  setup.cache = cache_;
  setup.counters = levelCounters_;
  auto made = std::make_shared<LevelledSurface>(std::move(setup));
  if (!(bound > 0)) checkBound(shape, made->longest());
  if (!ranges_.empty() && ranges_[shape].most > 0)
    checkScale(shape, patches->mesh(), geometry::Micropolygons(*patches->mesh()), nullptr, stop);
  return made;
}

}  // namespace kinora::render
