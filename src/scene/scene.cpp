#include "scene/scene.h"

#include <algorithm>

#include "scene/bytes.h"

namespace kinora::scene {

namespace {

template <class T>
T* byId(std::vector<T>& v, uint32_t id) {
  const auto it = std::find_if(v.begin(), v.end(), [id](const T& t) { return t.id == id; });
  return it == v.end() ? nullptr : &*it;
}

template <class T>
size_t bytesOf(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

template <class T>
size_t bytesOf(const LeanVector<T>& v) {
  return v.bytes();
}

// What copies share is counted by each.
size_t bytesOf(const Transform& t) { return t.times.heldBytes() + t.matrices.heldBytes(); }

size_t bytesOf(const Shape& s) {
  struct Count {
    size_t operator()(const PolygonMesh& m) const {
      return bytesOf(m.loopsPerFace) + bytesOf(m.verticesPerLoop) + bytesOf(m.vertices);
    }
    size_t operator()(const SubdivisionMesh& m) const {
      size_t n = bytesOf(m.verticesPerFace) + bytesOf(m.vertices) + bytesOf(m.tags);
      for (const auto& t : m.tags) n += bytesOf(t.ints) + bytesOf(t.floats);
      return n;
    }
    size_t operator()(const Curves& c) const { return bytesOf(c.verticesPerCurve); }
    size_t operator()(const NuPatch& p) const { return bytesOf(p.uKnots) + bytesOf(p.vKnots) + p.trim.bytes(); }
    size_t operator()(const OtherPrimitive& p) const { return p.args.bytes(); }
    size_t operator()(const Quadric&) const { return 0; }
    size_t operator()(const Points&) const { return 0; }
    size_t operator()(const Patch&) const { return 0; }
    size_t operator()(const PatchMesh&) const { return 0; }
  };
  return std::visit(Count{}, s);
}

size_t bytesOf(const Primitive& p) {
  size_t n =
      sizeof p + bytesOf(p.shape) + p.primvars.bytes() + bytesOf(p.times) + bytesOf(p.motion) + bytesOf(p.toWorld);
  for (const ParameterList& m : p.motion) n += m.bytes();
  return n;
}

size_t facesOf(const Primitive& p) {
  if (const auto* m = std::get_if<PolygonMesh>(&p.shape))
    return m->loopsPerFace.empty() ? m->verticesPerLoop.size() : m->loopsPerFace.size();
  if (const auto* m = std::get_if<SubdivisionMesh>(&p.shape)) return m->verticesPerFace.size();
  return 0;
}

}  // namespace

const char* requestName(const Shape& s) {
  struct Name {
    const char* operator()(const Quadric& q) const {
      static const char* const kNames[] = {"Sphere",     "Cone", "Cylinder", "Hyperboloid",
                                           "Paraboloid", "Disk", "Torus"};
      return kNames[int(q.kind)];
    }
    const char* operator()(const PolygonMesh& m) const {
      if (m.vertices.empty()) return m.loopsPerFace.empty() ? "Polygon" : "GeneralPolygon";
      return m.loopsPerFace.empty() ? "PointsPolygons" : "PointsGeneralPolygons";
    }
    const char* operator()(const SubdivisionMesh&) const { return "SubdivisionMesh"; }
    const char* operator()(const Curves&) const { return "Curves"; }
    const char* operator()(const Points&) const { return "Points"; }
    const char* operator()(const Patch&) const { return "Patch"; }
    const char* operator()(const PatchMesh&) const { return "PatchMesh"; }
    const char* operator()(const NuPatch&) const { return "NuPatch"; }
    const char* operator()(const OtherPrimitive& p) const { return p.request.c_str(); }
  };
  return std::visit(Name{}, s);
}

bool Attributes::says(Given what) const {
  static const Attributes kUsual;
  if (given & what) return true;
  switch (what) {
    case kTextureCoordinates:
      return textureCoordinates != kUsual.textureCoordinates;
    case kOrientation:
      return orientation != kUsual.orientation;
    case kReverseOrientation:
      return false;  // a toggle does not say a value
    case kSides:
      return sides != kUsual.sides;
    case kMatte:
      return matte != kUsual.matte;
    case kShadingInterpolation:
      return smoothShading != kUsual.smoothShading;
    case kShadingRate:
      return shadingRate != kUsual.shadingRate;
  }
  return false;
}

AttributesPtr inherit(const AttributesPtr& own, const AttributesPtr& instance) {
  if (!own) return instance;
  if (!instance) return own;
  auto out = std::make_shared<Attributes>(*instance);
  bool same = true;  // nothing of its own
  for (const Parameter& p : own->named) {
    same = false;
    Parameter mine = p;
    // "+name" adds to the groups that the instance has
    if (p.name == "grouping:membership" && !p.strings.empty() && p.strings[0].starts_with("+")) {
      const std::string outer = instance->named.getString(p.name, "");
      mine.strings[0] = outer + (outer.empty() ? "" : " ") + p.strings[0].substr(1);
    }
    out->named.set(std::move(mine));
  }
  const auto take = [&](auto Attributes::*member, bool said) {
    if (!said) return;
    same = same && out.get()->*member == (*own).*member;
    out.get()->*member = (*own).*member;
  };
  take(&Attributes::color, own->color.has_value());
  take(&Attributes::opacity, own->opacity.has_value());
  take(&Attributes::textureCoordinates, own->says(Attributes::kTextureCoordinates));
  take(&Attributes::orientation, own->says(Attributes::kOrientation));
  take(&Attributes::sides, own->says(Attributes::kSides));
  take(&Attributes::matte, own->says(Attributes::kMatte));
  take(&Attributes::smoothShading, own->says(Attributes::kShadingInterpolation));
  take(&Attributes::shadingRate, own->says(Attributes::kShadingRate));
  take(&Attributes::uBasis, true);
  take(&Attributes::vBasis, true);
  take(&Attributes::uStep, true);
  take(&Attributes::vStep, true);
  take(&Attributes::bxdf, own->bxdf != nullptr);
  take(&Attributes::displacement, own->displacement != nullptr);
  take(&Attributes::lightSources, own->lightSources != nullptr);
  // ReverseOrientation turns what the orientation is: the instance's, unless the object said one
  const bool absolute = own->says(Attributes::kOrientation) || own->says(Attributes::kReverseOrientation);
  out->reverseOrientation = own->reverseOrientation != (!absolute && instance->reverseOrientation);
  same = same && out->reverseOrientation == instance->reverseOrientation;
  for (const NodePtr& n : own->classicShaders) {
    same = false;
    std::erase_if(out->classicShaders, [&](const NodePtr& s) { return s->kind == n->kind; });
    out->classicShaders.push_back(n);
  }
  if (own->coordinateSystems) {
    same = same && own->coordinateSystems == instance->coordinateSystems;
    auto spaces = std::make_shared<std::map<std::string, Transform>>(*own->coordinateSystems);
    if (instance->coordinateSystems)
      spaces->insert(instance->coordinateSystems->begin(), instance->coordinateSystems->end());
    out->coordinateSystems = std::move(spaces);
  }
  if (same) return instance;
  out->given |= own->given;
  return out;
}

std::string Primitive::givenName() const {
  if (!attributes) return "";
  const std::string n = attributes->named.getString("identifier:name", "");
  return n.empty() ? attributes->named.getString("identifier:object", "") : n;
}

std::string Primitive::name() const {
  std::string n = givenName();
  if (!n.empty()) return n;
  n = requestName(shape);
  if (pos.file) n += " at " + pos.str();
  return n;
}

bool Scene::setPrimitiveTransform(uint32_t id, const Transform& t) {
  for (PrimitivePtr& p : primitives)
    if (p->id == id) {
      auto edited = std::make_shared<Primitive>(*p);
      edited->toWorld = t;
      p = std::move(edited);
      return true;
    }
  return false;
}

bool Scene::setPrimitiveAttributes(uint32_t id, AttributesPtr a) {
  for (PrimitivePtr& p : primitives)
    if (p->id == id) {
      auto edited = std::make_shared<Primitive>(*p);
      edited->attributes = std::move(a);
      p = std::move(edited);
      return true;
    }
  return false;
}

bool Scene::replacePrimitive(uint32_t id, Primitive replacement) {
  for (PrimitivePtr& p : primitives)
    if (p->id == id) {
      replacement.id = id;
      p = std::make_shared<Primitive>(std::move(replacement));
      return true;
    }
  return false;
}

bool Scene::removePrimitive(uint32_t id) {
  const auto it =
      std::find_if(primitives.begin(), primitives.end(), [id](const PrimitivePtr& p) { return p->id == id; });
  if (it == primitives.end()) return false;
  primitives.erase(it);
  return true;
}

bool Scene::setInstanceTransform(uint32_t id, const Transform& t) {
  const size_t at = instances.find(id);
  if (at == instances.size()) return false;
  instances.edit(at, [&](Instance& i) { i.toWorld = t; });
  return true;
}

bool Scene::setLight(uint32_t id, Light l) {
  Light* held = byId(lights, id);
  if (!held) return false;
  l.id = id;
  *held = std::move(l);
  return true;
}

bool Scene::setCamera(size_t index, Camera c) {
  if (index >= cameras.size()) return false;
  cameras[index] = std::move(c);
  return true;
}

uint32_t Scene::add(Primitive p) {
  p.id = nextId++;
  primitives.push_back(std::make_shared<Primitive>(std::move(p)));
  return primitives.back()->id;
}

uint32_t Scene::add(Light l) {
  l.id = nextId++;
  lights.push_back(std::move(l));
  return lights.back().id;
}

uint32_t Scene::add(Instance i) {
  i.id = nextId++;
  instances.push_back(std::move(i));
  return nextId - 1;
}

size_t bytesHeld(const Primitive& primitive) { return bytesOf(primitive); }

size_t Scene::bytes() const { return statistics().bytes; }

SceneStatistics Scene::statistics() const {
  SceneStatistics s;
  const Attributes* last = nullptr;  // objects that share attributes mostly follow each other
  size_t n = sizeof *this + options.bytes() + bytesOf(primitives) + bytesOf(prototypes) + bytesOf(lights) +
             bytesOf(classicLights) + bytesOf(kept) + bytesOf(solids);
  const auto addAttributes = [&](const AttributesPtr& a) {
    if (a && a.get() != last) n += sizeof(Attributes) + a->named.size() * sizeof(std::shared_ptr<Parameter>);
    last = a.get();
  };
  const auto addPrimitive = [&](const Primitive& p) {
    n += bytesOf(p);
    addAttributes(p.attributes);
    s.faces += facesOf(p);
    ++s.primitives;
  };
  const auto addInstances = [&](const InstanceList& list) {
    n += list.heldBytes();
    for (size_t i = 0; i < list.size(); ++i) addAttributes(list.attributesOf(i));
    s.instances += list.size();
  };
  for (const auto& p : primitives) addPrimitive(*p);
  addInstances(instances);
  for (const Prototype& o : prototypes) {
    n += bytesOf(o.primitives) + bytesOf(o.lights) + bytesOf(o.solids);
    for (const auto& p : o.primitives) addPrimitive(*p);
    addInstances(o.instances);
    s.lights += o.lights.size();
  }
  for (const auto* list : {&lights, &classicLights})
    for (const Light& l : *list) {
      n += bytesOf(l.toWorld) + (l.node ? sizeof(Node) + l.node->params.bytes() : 0);
      if (l.geometry) n += bytesOf(*l.geometry);
    }
  for (const KeptRequest& k : kept) n += k.params.bytes();
  s.lights += lights.size() + classicLights.size();
  s.prototypes = prototypes.size();
  s.kept = kept.size();
  s.bytes = n;
  return s;
}

}  // namespace kinora::scene
