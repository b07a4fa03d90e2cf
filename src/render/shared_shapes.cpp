#include "render/shared_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "render/matrix_scale.h"
#include "scene/digests.h"

namespace kinora::render {

namespace {

using scene::Quadric;

// The arguments that are lengths, of those in the order of the request; the others are angles.
size_t lengthsOf(Quadric::Kind kind) {
  switch (kind) {
    case Quadric::Kind::Sphere:
    case Quadric::Kind::Cylinder:
    case Quadric::Kind::Paraboloid:
      return 3;
    case Quadric::Kind::Cone:
    case Quadric::Kind::Disk:
    case Quadric::Kind::Torus:
      return 2;
    case Quadric::Kind::Hyperboloid:
      return 6;
  }
  return 0;
}

// A power of two that its radius in pixels does not exceed; nothing where it is large, or nowhere.
std::optional<double> pixelsOf(const scene::Transform& toWorld, double size, const View& view) {
  const scene::Matrix m = toWorld.at(view.middle);
  const double radius = size * scaleOf(m);
  const double distance = (m.translation() - view.eye).length() - 2 * radius;
  const double pixels = radius / std::max(view.pixelSize, std::max(distance, 0.0) * view.pixelAngle);
  if (!(pixels > 0 && pixels <= SharedShapes::kMostPixels)) return std::nullopt;
  return std::exp2(std::max(std::ceil(std::log2(pixels)), -2.0));
}

void addDeclarations(Hasher& h, const scene::ParameterList& list) {
  h.word(list.size());
  for (const scene::Parameter& p : list) {
    h.text(p.name);
    h.word(uint64_t(p.storage) | uint64_t(p.type) << 8 | uint64_t(p.isArray) << 16 |
           uint64_t(uint32_t(p.arrayLength)) << 32);
  }
}

// A shape that lets light through in one of its places does so in all, for shadow rays: kinds of materials stay apart.
void addClearness(Hasher& h, const scene::Attributes* a) {
  h.text(a && a->bxdf && a->bxdf->terminal ? a->bxdf->terminal->plugin : std::string());
  h.word(a && a->opacity && *a->opacity != std::array<float, 3>{1, 1, 1});
}

// A single patch: it closes no volume, so that no ray can tell whose surface it entered by.
bool canJoin(const scene::Primitive& p) {
  if (!std::holds_alternative<scene::Patch>(p.shape) || !p.motion.empty() || p.solid != 0) return false;
  return std::none_of(p.primvars.begin(), p.primvars.end(), [](const scene::Parameter& v) {
    return v.isReference || !v.strings.empty() || v.type == scene::ValueType::String;
  });
}

}  // namespace

std::optional<UnitQuadric> unitQuadricOf(const scene::Primitive& p) {
  const auto* q = std::get_if<Quadric>(&p.shape);
  if (!q || !p.motion.empty() || p.solid != 0) return std::nullopt;
  for (const scene::Parameter& v : p.primvars) switch (v.type) {
      case scene::ValueType::Float:
      case scene::ValueType::Int:
      case scene::ValueType::Color:
      case scene::ValueType::String:
        break;
      default:
        return std::nullopt;
    }
  UnitQuadric unit{*q, 0};
  const size_t lengths = lengthsOf(q->kind);
  for (size_t i = 0; i < lengths; ++i) unit.size = std::max(unit.size, std::fabs(double(q->args[i])));
  if (!std::isfinite(unit.size) || !(unit.size > 1e-30)) return std::nullopt;
  for (size_t i = 0; i < lengths; ++i) {
    if (!std::isfinite(q->args[i])) return std::nullopt;
    unit.quadric.args[i] = float(double(q->args[i]) / unit.size);
  }
  for (size_t i = lengths; i < q->args.size(); ++i)
    if (!std::isfinite(q->args[i])) return std::nullopt;
  return unit;
}

SharedShapes sharedShapesOf(const std::vector<scene::PrimitivePtr>& primitives, const View& view,
                            const std::set<uint32_t>& leaveOut,
                            const std::function<Digest(const scene::Attributes*)>& look) {
  SharedShapes shared;
  if (primitives.size() < std::min(SharedShapes::kLeastUnits, SharedShapes::kLeastJoined)) return shared;
  std::vector<SharedShapes::Group> found;
  std::map<Digest, uint32_t> open;  // the group that takes more of a kind
  size_t units = 0;
  std::vector<uint32_t> in(primitives.size(), SharedShapes::kNone);
  for (uint32_t i = 0; i < primitives.size(); ++i) {
    const scene::Primitive& p = *primitives[i];
    if ((p.attributes && p.attributes->displacement) || leaveOut.count(p.id)) continue;
    Hasher h;
    double pixels = 0;
    const std::optional<UnitQuadric> unit = unitQuadricOf(p);
    if (unit) {
      ++units;
      const std::optional<double> size = pixelsOf(p.toWorld, unit->size, view);
      if (!size) continue;
      pixels = *size;
      h.word(uint64_t(unit->quadric.kind));
      h.bytes(unit->quadric.args.data(), sizeof unit->quadric.args);
      h.bytes(&pixels, sizeof pixels);
      h.digest(look(p.attributes.get()));
      addClearness(h, p.attributes.get());
      h.word(p.primvars.size());
      if (!p.primvars.empty()) h.digest(scene::digestOf(p.primvars));
    } else if (canJoin(p)) {
      h.word(~uint64_t(0) - std::get<scene::Patch>(p.shape).bicubic);
      h.word(reinterpret_cast<uintptr_t>(p.attributes.get()));
      h.word(p.toWorld.times.size());
      h.bytes(p.toWorld.times.data(), p.toWorld.times.size() * sizeof(double));
      h.bytes(p.toWorld.matrices.data(), p.toWorld.matrices.size() * sizeof(scene::Matrix));
      addDeclarations(h, p.primvars);
    } else {
      continue;
    }
    const auto [it, isNew] = open.try_emplace(h.result(), uint32_t(found.size()));
    if (!isNew && !unit && found[it->second].members.size() == SharedShapes::kMostJoined)
      it->second = uint32_t(found.size());
    if (it->second == found.size()) found.push_back({unit.has_value(), pixels, {}});
    found[it->second].members.push_back(i);
    in[i] = it->second;
  }
  shared.asksView = units >= SharedShapes::kLeastUnits;
  // Few alike stand for themselves.
  std::vector<uint32_t> numberOf(found.size(), SharedShapes::kNone);
  for (size_t g = 0; g < found.size(); ++g) {
    if (found[g].members.size() < (found[g].isUnit ? SharedShapes::kLeastUnits : SharedShapes::kLeastJoined))
      continue;
    numberOf[g] = uint32_t(shared.groups.size());
    shared.groups.push_back(std::move(found[g]));
  }
  if (shared.groups.empty()) return shared;
  shared.groupOf = std::move(in);
  for (uint32_t& g : shared.groupOf)
    if (g != SharedShapes::kNone) g = numberOf[g];
  return shared;
}

}  // namespace kinora::render
