#include "geometry/strand.h"

#include <algorithm>
#include <cmath>

namespace kinora::geometry {

using Imath::V3d;
using scene::StorageClass;

StrandSources::StrandSources(const scene::Primitive& primitive, const PointKeys& points, const ClassCounts& counts,
                             Diagnostics& diagnostics)
    : primitive_(primitive), points_(points), diagnostics_(diagnostics) {
  primvars_ = readPrimvars(primitive, counts, diagnostics);
  for (const SourcePrimvar& s : primvars_) {
    const std::string& name = s.parameter->name;
    const bool one = s.parameter->elementFloats() == 1 && !s.values.empty();
    if (one && (name == "width" || (name == "constantwidth" && !widthSource_))) widthSource_ = &s;
    if (name == "N" && s.parameter->elementFloats() == 3) normals_ = &s;
  }
  if (!widthSource_) return;
  size_t negative = 0, bad = 0;
  float good = 1;  // rib.md 7.5: missing widths are 1
  bool found = false;
  for (size_t key = 0; key < points.keys.size(); ++key) {
    std::span<const float> v = valuesAtKey(primitive, *widthSource_, key);
    if (v.empty()) v = widthSource_->values;
    widths_.emplace_back(v.begin(), v.end());
    for (const float w : v) {
      negative += w < 0;
      bad += !std::isfinite(w);
      if (!found && std::isfinite(w) && w > 0) {
        good = w;
        found = true;
      }
    }
  }
  if (bad)
    for (std::vector<float>& key : widths_)
      for (float& w : key)
        if (!std::isfinite(w)) w = good;
  if (bad || negative)
    diagnostics.warning(
        "GEOM-WIDTH", primitive.pos,
        std::to_string(bad + negative) + " widths of " + subject(primitive) + " are " +
            (bad && negative ? "negative or not finite"
             : bad           ? "not finite"
                             : "negative"),
        bad ? "those that are no number become " + std::to_string(good) : "they count as 0 where they stand");
}

double StrandSources::mix(std::span<const float> values, StorageClass storage, int width, int component,
                          const ControlSource& c) const {
  const auto at = [&](size_t element) { return double(values[element * size_t(width) + size_t(component)]); };
  switch (storage) {
    case StorageClass::Constant:
      return at(0);
    case StorageClass::Uniform:
      return at(c.curve);
    case StorageClass::Vertex: {
      double sum = 0;
      for (int k = 0; k < 4; ++k)
        if (c.weight[k] != 0) sum += double(c.weight[k]) * at(c.vertex[k]);
      return sum;
    }
    default:  // varying, and what comes to the same on strands
      if (c.between == 0) return at(c.varying[0]);
      return (1 - double(c.between)) * at(c.varying[0]) + double(c.between) * at(c.varying[1]);
  }
}

V3d StrandSources::position(size_t key, const ControlSource& c) const {
  V3d p(0);
  for (int k = 0; k < 4; ++k)
    if (c.weight[k] != 0) p += points_.point(key, c.vertex[k]) * double(c.weight[k]);
  return p;
}

double StrandSources::radius(size_t key, const ControlSource& c) const {
  if (!widthSource_) return 0.5;
  return std::max(0.0, 0.5 * mix(widthsAt(key), widthSource_->storage, 1, 0, c));
}

V3d StrandSources::normal(size_t key, const ControlSource& c) const {
  std::span<const float> v = valuesAtKey(primitive_, *normals_, key);
  if (v.empty()) v = normals_->values;
  V3d n;
  for (int k = 0; k < 3; ++k) n[k] = mix(v, normals_->storage, 3, k, c);
  return n;
}

void StrandSources::store(size_t count, const std::function<void(const Visit&)>& walk, Mesh& mesh) const {
  mesh.vertexCount = uint32_t(count);
  const auto each = [&](const auto& visit) {
    walk([&](std::span<const ControlSource> some) {
      for (const ControlSource& c : some) visit(c);
    });
  };
  mesh.origin = chooseOrigin(mesh.bounds);
  mesh.spine.reserve(count * keys() + 1);
  for (size_t key = 0; key < keys(); ++key)
    each([&](const ControlSource& c) {
      const Imath::V3f p(position(key, c) - mesh.origin);
      mesh.spine.emplace_back(p.x, p.y, p.z, float(radius(key, c)));
    });
  size_t unusable = 0;
  if (mesh.isOriented())
    for (size_t key = 0; key < keys(); ++key)
      each([&](const ControlSource& c) {
        V3d n = normal(key, c);
        const double length = n.length();
        const bool good = length > 0 && std::isfinite(length);
        unusable += !good;
        n = good ? n / length : V3d(0, 0, 1);
        mesh.spineNormals.emplace_back(Imath::V3f(mesh.flipNormals ? -n : n));
      });
  if (unusable)
    diagnostics_.warning("GEOM-NORMAL", primitive_.pos,
                         std::to_string(unusable) + " normals of " + subject(primitive_) + " are zero or not finite",
                         "(0, 0, 1) takes their place");
  if (keys() > 1) mesh.times = points_.times;

  for (const SourcePrimvar& s : primvars_) {
    if (s.parameter->name == "N" || s.parameter->name == "width") continue;  // part of the shape here
    using Rate = Primvar::Rate;
    const Rate rate = s.storage == StorageClass::Constant || (s.storage == StorageClass::Uniform && s.elements == 1)
                          ? Rate::Constant
                      : s.storage == StorageClass::Uniform ? Rate::PerFace
                                                           : Rate::PerVertex;
    Primvar p = emptyPrimvar(s, rate);
    if (rate != Rate::PerVertex) {
      p.data = s.values;
    } else {
      p.data.reserve(count * size_t(p.width));
      each([&](const ControlSource& c) {
        for (int k = 0; k < p.width; ++k) p.data.push_back(float(mix(s.values, s.storage, p.width, k, c)));
      });
    }
    mesh.primvars.push_back(std::move(p));
  }
  joinTextureCoordinates(mesh);
}

}  // namespace kinora::geometry
