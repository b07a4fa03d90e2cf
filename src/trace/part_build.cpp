// How a part of a World is made: its meshes moved into render space where it is a batch, and the hierarchy over them. Where
// parts stand, and what stands over them, is of world_build.cpp.
#include <map>

#include "trace/embree_device.h"
#include "trace/strands.h"
#include "trace/user_calls.h"
#include "trace/world_part.h"

namespace kinora::trace {

namespace {

constexpr uint32_t kMergeBelow = 256;  // triangles: smaller shapes of a batch share one Embree geometry

}  // namespace

void World::Part::build() {
  scene = rtcNewScene(device());
  int flags = watertight ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE;
  for (const uint32_t v : visibility)
    if (v & (kSeenByClearShadow | kAskedAlone))
      flags |= RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;  // for collectClear() and closestOn()
  rtcSetSceneFlags(scene, RTCSceneFlags(flags));
  std::map<uint32_t, std::vector<uint32_t>> small;  // visibility -> shapes to merge
  const auto attach = [&](RTCGeometry g, uint32_t mask) {
    if (ofSolid) Solids::setFilters(g);
    rtcSetGeometryMask(g, mask);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(scene, g, uint32_t(firstSlice.size()));
    rtcReleaseGeometry(g);
    firstSlice.push_back(uint32_t(slices.size()));
  };
  for (uint32_t i = 0; i < meshes.size(); ++i) {
    geometry::Mesh& mesh = *meshes[i];
    if (users[i]) {
      hasUser = true;
      attach(makeUserGeometry(device(), *users[i]), visibility[i]);
      slices.push_back({0, i});
      continue;
    }
    if (!mesh.primitiveCount()) continue;
    if (mesh.isStrand()) {
      attach(makeStrands(device(), mesh), visibility[i]);
      slices.push_back({0, i});
      continue;
    }
    if (mesh.triangleCount() < kMergeBelow && mesh.keyCount() == 1 && meshes.size() > 1) {
      small[visibility[i]].push_back(i);
      continue;
    }
    const RTCGeometry g = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads 16 bytes at each vertex: one float beyond the last must be there
    mesh.points.reserve(mesh.points.size() + 2);
    rtcSetGeometryTimeStepCount(g, unsigned(mesh.keyCount()));
    for (int k = 0; k < mesh.keyCount(); ++k)
      rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, unsigned(k), RTC_FORMAT_FLOAT3, mesh.points.data(),
                                 size_t(k) * mesh.vertexCount * sizeof(Imath::V3f), sizeof(Imath::V3f),
                                 mesh.vertexCount);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                               3 * sizeof(uint32_t), mesh.triangleCount());
    attach(g, visibility[i]);
    slices.push_back({0, i});
  }
  for (const auto& [mask, shapes] : small) {
    auto& points = mergedPoints.emplace_back();
    auto& indices = mergedIndices.emplace_back();
    const uint32_t first = uint32_t(slices.size());
    for (uint32_t s : shapes) {
      const geometry::Mesh& mesh = *meshes[s];
      const uint32_t base = uint32_t(points.size() / 3);
      slices.push_back({uint32_t(indices.size() / 3), s});
      for (uint32_t v = 0; v < mesh.vertexCount; ++v)
        points.insert(points.end(), {mesh.points[v].x, mesh.points[v].y, mesh.points[v].z});
      for (uint32_t id : mesh.indices) indices.push_back(base + id);
    }
    points.push_back(0);
    const RTCGeometry g = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, points.data(), 0, 12,
                               points.size() / 3);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices.data(), 0, 12,
                               indices.size() / 3);
    attach(g, mask);
    firstSlice.back() = first;
  }
  firstSlice.push_back(uint32_t(slices.size()));
  placeOfShape.assign(meshes.size(), {kNone, 0});
  for (uint32_t g = 0; g + 1 < firstSlice.size(); ++g)
    for (uint32_t k = firstSlice[g]; k < firstSlice[g + 1]; ++k) placeOfShape[slices[k].shape] = {g, slices[k].start};
  rtcCommitScene(scene);
  throwIfRefused();
  RTCBounds b;
  rtcGetSceneBounds(scene, &b);
  lower[0] = b.lower_x;
  lower[1] = b.lower_y;
  lower[2] = b.lower_z;
  upper[0] = b.upper_x;
  upper[1] = b.upper_y;
  upper[2] = b.upper_z;
}

void bake(geometry::Mesh& mesh, const scene::Matrix& toRender) {
  const scene::Matrix local = scene::Matrix().setTranslation(mesh.origin) * toRender;
  bakeStrands(mesh, local);
  for (std::vector<Imath::V3f>* points : {&mesh.points, &mesh.rest})
    for (Imath::V3f& p : *points) {
      const Imath::V3d q = Imath::V3d(p) * local;
      p = Imath::V3f(q);
    }
  mesh.origin = {0, 0, 0};
  // edges turn with the points, so a mirroring transform turns e1 x e2 against the normal's own transform
  if (!mesh.isStrand() && toRender.determinant() < 0) mesh.flipNormals = !mesh.flipNormals;
  const scene::Matrix it = toRender.inverse().transposed();
  for (geometry::Primvar& v : mesh.primvars) {
    const bool shading = v.name == "N", point = v.type == scene::ValueType::Point,
               vector = v.type == scene::ValueType::Vector;
    if (v.width % 3 != 0 || !(shading || point || vector || v.type == scene::ValueType::Normal)) continue;
    for (size_t i = 0; i + 2 < v.data.size(); i += 3) {
      const Imath::V3d x(v.data[i], v.data[i + 1], v.data[i + 2]);
      Imath::V3d y;
      if (point && !shading)
        y = x * toRender;
      else if (vector && !shading)
        toRender.multDirMatrix(x, y);
      else
        it.multDirMatrix(x, y);
      if (shading) y.normalize();
      for (int k = 0; k < 3; ++k) v.data[i + size_t(k)] = float(y[k]);
    }
  }
}

}  // namespace kinora::trace
