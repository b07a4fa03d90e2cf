// What the kinds of edits share. Used by tests/edits/edits_of_*.cpp only.
#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/edits/edited_scene.h"

namespace kinora::tests {

using namespace scene;

using R = RandomEdits;

// One kind of edit; "" when the scene has nothing to edit so.
struct Kind {
  const char* name;
  std::string (*apply)(Scene&, R&);
};
std::span<const Kind> editsOfFrames();   // camera, frame, lights
std::span<const Kind> editsOfObjects();  // materials, attributes, shapes, instances

inline Matrix moved(R& r) {
  Matrix m;
  m.setTranslation(Imath::V3d(r.number(-0.5, 0.5), r.number(-0.3, 0.5), r.number(-0.5, 0.5)));
  if (r.coin()) m = Matrix().setAxisAngle(Imath::V3d(0.2, 1, 0.1).normalized(), r.number(-0.6, 0.6)) * m;
  if (r.below(6) == 0) m = Matrix().setScale(Imath::V3d(-1, 1, r.number(0.5, 1.5))) * m;
  return m;
}
inline Transform moved(const Transform& t, R& r) { return concat(t, Transform::fixed(moved(r))); }
// Makes it move, stand still, or move otherwise.
inline Transform animated(const Transform& t, R& r) {
  if (!t.isStatic() && r.coin()) return Transform::fixed(t.matrices[0]);
  Transform out = t;
  out.matrices = {t.matrices[0], t.matrices[0] * moved(r)};
  out.times = {0, r.coin() ? 1.0 : 0.7};
  return out;
}
inline Parameter parameter(const std::string& name, ValueType type, std::vector<float> floats) {
  Parameter p;
  p.name = name;
  p.type = type;
  p.floats = std::move(floats);
  return p;
}
inline Parameter text(const std::string& name, const std::string& value) {
  Parameter p;
  p.name = name;
  p.type = ValueType::String;
  p.strings = {value};
  return p;
}
inline Parameter integer(const std::string& name, int value) {
  Parameter p;
  p.name = name;
  p.type = ValueType::Int;
  p.ints = {value};
  return p;
}
template <class T>
const T* any(const std::vector<T>& list, R& r) {
  return list.empty() ? nullptr : &list[r.below(list.size())];
}

// One of all primitives, in the world or in an object, for exchange.
inline PrimitivePtr* anyPrimitive(Scene& s, R& r) {
  std::vector<PrimitivePtr*> all;
  for (PrimitivePtr& p : s.primitives) all.push_back(&p);
  for (Prototype& o : s.prototypes)
    for (PrimitivePtr& p : o.primitives) all.push_back(&p);
  return all.empty() ? nullptr : all[r.below(all.size())];
}
inline std::string nameOf(const PrimitivePtr& p) { return " of " + p->name(); }

using Change = std::function<bool(Primitive&)>;
// Half of the edits go through the scene's functions, half past them: both must be seen.
inline std::string change(Scene& s, R& r, const char* what, const Change& edit) {
  PrimitivePtr* at = anyPrimitive(s, r);
  if (!at) return "";
  Primitive copy = **at;
  if (!edit(copy)) return "";
  const std::string done = what + nameOf(*at);
  const bool isInWorld = std::any_of(s.primitives.begin(), s.primitives.end(), [&](auto& p) { return &p == at; });
  if (!isInWorld || r.coin() || !s.replacePrimitive(copy.id, copy))
    *at = std::make_shared<Primitive>(std::move(copy));
  return done;
}
// Of a primitive that has points; edit() gets them too.
inline std::string changePoints(Scene& s, R& r, const char* what,
                                const std::function<void(Primitive&, std::vector<float>&)>& edit) {
  return change(s, r, what, [&](Primitive& p) {
    Parameter* points = p.primvars.find("P");
    if (!points || points->floats.empty()) return false;
    edit(p, points->floats);
    return true;
  });
}
inline std::string changeAttributes(Scene& s, R& r, const char* what, const std::function<bool(Attributes&)>& edit) {
  if (!s.instances.empty() && r.below(4) == 0) {
    const size_t at = r.below(s.instances.size());
    const AttributesPtr own = s.instances.attributesOf(at);
    auto a = std::make_shared<Attributes>(own ? *own : Attributes());
    if (!edit(*a)) return "";
    s.instances.edit(at, [&](Instance& i) { i.attributes = std::move(a); });
    return std::string(what) + " of an instance";
  }
  return change(s, r, what, [&](Primitive& p) {
    auto a = std::make_shared<Attributes>(p.attributes ? *p.attributes : Attributes());
    if (!edit(*a)) return false;
    p.attributes = std::move(a);
    return true;
  });
}
inline std::string changeNetwork(Scene& s, R& r, const char* what, const std::function<bool(Network&)>& edit) {
  return changeAttributes(s, r, what, [&](Attributes& a) {
    if (!a.bxdf) return false;
    auto n = std::make_shared<Network>(*a.bxdf);
    if (!edit(*n)) return false;
    a.bxdf = std::move(n);
    return true;
  });
}
inline NodePtr with(const NodePtr& node, Parameter p) {
  auto n = std::make_shared<Node>(*node);
  n->params.set(std::move(p));
  return n;
}
// One of these texts for a parameter of the first pattern of a plug-in.
inline std::string changePattern(Scene& s, R& r, const char* what, const char* plugin, const char* parameter,
                                 const std::vector<const char*>& texts) {
  return changeNetwork(s, r, what, [&](Network& n) {
    for (NodePtr& p : n.patterns)
      if (p->plugin == plugin) {
        p = with(p, text(parameter, texts[r.below(texts.size())]));
        return true;
      }
    return false;
  });
}
inline NodePtr node(const char* kind, const char* plugin, const char* handle) {
  auto n = std::make_shared<Node>();
  n->kind = kind;
  n->plugin = plugin;
  n->handle = handle;
  return n;
}

inline Light someLight(R& r) {
  static const char* const kPlugins[] = {"PxrSphereLight", "PxrRectLight", "PxrDiskLight", "PxrDistantLight",
                                         "PxrDomeLight",   "PointLight",   "NoSuchLight"};
  Light l;
  auto n = std::make_shared<Node>();
  n->kind = "Light";
  n->plugin = kPlugins[r.below(std::size(kPlugins))];
  n->handle = "added" + std::to_string(r.below(3));
  n->params.set(parameter("intensity", ValueType::Float, {float(r.number(0.2, 4))}));
  l.node = n;
  l.toWorld = Transform::fixed(Matrix().setTranslation(Imath::V3d(r.number(-2, 2), 2, r.number(-2, 2))));
  return l;
}
inline Primitive somePrimitive(Scene& s, R& r) {
  Primitive p;
  if (r.coin()) {
    p.shape = Quadric{Quadric::Kind(r.below(7)), {0.3f, -0.3f, 0.3f, 360, 0, 360, 360}};
    if (std::get<Quadric>(p.shape).kind == Quadric::Kind::Disk) std::get<Quadric>(p.shape).args = {0, 0.4f, 360};
  } else {
    PolygonMesh m;
    m.verticesPerLoop = {3};
    m.vertices = {0, 1, 2};
    p.shape = m;
    Parameter points = parameter("P", ValueType::Point, {0, 0, 0, 1, 0, 0, 0.5f, 0.8f, 0});
    points.storage = StorageClass::Vertex;
    p.primvars.set(points);
  }
  if (!s.primitives.empty() && r.coin()) p.attributes = s.primitives[r.below(s.primitives.size())]->attributes;
  p.toWorld = moved(Transform(), r);
  return p;
}

}  // namespace kinora::tests
