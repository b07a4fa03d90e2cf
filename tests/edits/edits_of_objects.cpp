#include "scene/edits_testing.h"
#include "tests/edits/edit_kinds.h"

namespace kinora::tests {

namespace {

const Kind kKindsOfObjects[] = {
    {"material parameter",
     [](Scene& s, R& r) -> std::string {
       return changeNetwork(s, r, "material parameter", [&](Network& n) {
         if (!n.terminal) return false;
         const int which = int(r.below(4));
         n.terminal =
             with(n.terminal,
                  which == 0   ? parameter("diffuseColor", ValueType::Color, {float(r.number(0, 1)), 0.4f, 0.3f})
                  : which == 1 ? parameter("specularRoughness", ValueType::Float, {float(r.number(0.1, 0.6))})
                  : which == 2 ? parameter("presence", ValueType::Float, {r.coin() ? 1.f : float(r.number(0.2, 1))})
                               : integer("noSuchParameter", 1));
         return true;
       });
     }},
    {"pattern parameter",
     [](Scene& s, R& r) -> std::string {
       return changeNetwork(s, r, "pattern parameter", [&](Network& n) {
         if (n.patterns.empty()) return false;
         NodePtr& p = n.patterns[r.below(n.patterns.size())];
         p = with(p, r.coin() ? parameter("at", ValueType::Float, {float(r.number(0, 1))})
                              : parameter("size", ValueType::Float, {float(r.number(1, 5))}));
         return true;
       });
     }},
    {"displacement",
     [](Scene& s, R& r) {
       return changeAttributes(s, r, "displacement", [&](Attributes& a) {
         auto n = std::make_shared<Network>(a.displacement ? *a.displacement : Network());
         if (!n->terminal || r.below(4) == 0)
           n->terminal = node("Displace", r.coin() ? "PxrDisplace" : "NoSuchDisplacement", "bumps");
         if (n->patterns.empty() && a.bxdf && r.coin()) {
           n->patterns = a.bxdf->patterns;
           for (const NodePtr& p : n->patterns)
             if (p->plugin == "PxrTexture" || p->plugin == "PxrOSL") {
               Parameter from = text("dispScalar", p->handle + ":resultRGB");
               from.isReference = true;
               n->terminal = with(n->terminal, from);
             }
         }
         n->terminal = with(n->terminal,
                            r.below(3) ? parameter("dispAmount", ValueType::Float, {float(r.number(-0.3, 0.3))})
                                       : parameter("dispVector", ValueType::Vector, {0, float(r.number(0, 0.3)), 0}));
         a.displacement = r.below(6) ? std::move(n) : nullptr;
         return true;
       });
     }},
    {"texture",
     [](Scene& s, R& r) {
       return changePattern(s, r, "texture", "PxrTexture", "filename", {"wood.png", "brick.png", "none.png"});
     }},
    {"shader",
     [](Scene& s, R& r) {
       return changePattern(s, r, "shader", "PxrOSL", "shader", {"stripe", "spots", "none"});
     }},
    {"network structure",
     [](Scene& s, R& r) -> std::string {
       return changeNetwork(s, r, "network", [&](Network& n) {
         const int which = int(r.below(3));
         if (which == 0 && !n.patterns.empty()) {
           n.patterns.pop_back();
         } else if (which == 1 && n.terminal) {
           auto checker = std::make_shared<Node>(*node("Pattern", "PxrChecker", "squares"));
           checker->params.set(parameter("colorA", ValueType::Color, {float(r.number(0, 1)), 0.5f, 0}));
           n.patterns.push_back(checker);
           Parameter p = text("diffuseColor", "squares:resultRGB");
           p.type = ValueType::Color;
           p.isReference = true;
           n.terminal = with(n.terminal, p);
         } else {
           static const char* const kBxdfs[] = {"PxrDiffuse", "PxrSurface", "PxrGlass", "PxrConstant", "NoSuchBxdf"};
           auto t = std::make_shared<Node>(n.terminal ? *n.terminal : Node());
           t->plugin = kBxdfs[r.below(std::size(kBxdfs))];
           n.terminal = t;
         }
         return true;
       });
     }},
    {"material exchanged",
     [](Scene& s, R& r) -> std::string {
       const PrimitivePtr* other = any(s.primitives, r);
       if (!other) return "";
       const NetworkPtr network = (*other)->attributes ? (*other)->attributes->bxdf : nullptr;
       return changeAttributes(s, r, "material", [&](Attributes& a) {
         a.bxdf = r.below(4) ? network : nullptr;
         return true;
       });
     }},
    {"attribute",
     [](Scene& s, R& r) -> std::string {
       return changeAttributes(s, r, "attribute", [&](Attributes& a) {
         switch (r.below(14)) {
           case 0:
             a.named.set(integer("visibility:camera", int(r.below(2))));
             break;
           case 1:
             a.named.set(integer("visibility:indirect", int(r.below(2))));
             break;
           case 2:
             a.named.set(integer("visibility:transmission", int(r.below(2))));
             break;
           case 3:
             a.sides = 1 + int(r.below(2));
             break;
           case 4:
             a.orientation = Attributes::Orientation(r.below(4));
             break;
           case 5:
             a.reverseOrientation = !a.reverseOrientation;
             break;
           case 6:
             a.color = {float(r.number(0, 1)), 0.5f, 0.2f};
             break;
           case 7:
             a.opacity = {float(r.number(0, 1)), 0.5f, 0.5f};
             break;
           case 8:
             a.matte = !a.matte;
             break;
           case 9:
             a.textureCoordinates[r.below(8)] += 0.5f;
             break;
           case 10:
             a.named.set(parameter("user:wear", ValueType::Float, {float(r.number(0, 1))}));
             break;
           case 11:
             a.named.set(integer("trace:intersectpriority", int(r.below(3))));
             break;
           case 12:
             a.named.set(parameter("dice:micropolygonlength", ValueType::Float, {float(r.number(0.5, 8))}));
             break;
           default:
             a.named.set(integer("polygon:smoothnormals", int(r.below(2))));
             break;
         }
         return true;
       });
     }},
    {"subsets",
     [](Scene& s, R& r) -> std::string {
       return changeAttributes(s, r, "subset", [&](Attributes& a) {
         static const char* const kNames[] = {"trace:reflectsubset",         "trace:shadowsubset",
                                              "trace:transmitexcludesubset", "lighting:subset",
                                              "lighting:excludesubset",      "grouping:membership"};
         a.named.set(text(kNames[r.below(std::size(kNames))], r.coin() ? "balls" : "lamps"));
         return true;
       });
     }},
    {"basis",
     [](Scene& s, R& r) -> std::string {
       return changeAttributes(s, r, "basis", [&](Attributes& a) {
         a.vBasis = Attributes::kBezier;
         a.vStep = r.coin() ? 3 : 1;
         return true;
       });
     }},
    {"object's coordinate system",
     [](Scene& s, R& r) -> std::string {
       return changeAttributes(s, r, "coordinate system", [&](Attributes& a) {
         a.coordinateSystems = std::make_shared<const std::map<std::string, Transform>>(
             std::map<std::string, Transform>{{"mark", moved(Transform(), r)}});
         return true;
       });
     }},
    {"object moves",
     [](Scene& s, R& r) -> std::string {
       return change(s, r, "transform", [&](Primitive& p) {
         p.toWorld = moved(p.toWorld, r);
         return true;
       });
     }},
    {"object animated",
     [](Scene& s, R& r) -> std::string {
       return change(s, r, "motion", [&](Primitive& p) {
         p.toWorld = animated(p.toWorld, r);
         return true;
       });
     }},
    {"points move",
     [](Scene& s, R& r) -> std::string {
       return changePoints(s, r, "points", [&](Primitive&, std::vector<float>& points) {
         points[r.below(points.size())] += float(r.number(-0.4, 0.4));
       });
     }},
    {"deformation",
     [](Scene& s, R& r) -> std::string {
       return changePoints(s, r, "deformation", [&](Primitive& p, std::vector<float>&) {
         if (!p.motion.empty() && r.coin()) {
           p.motion.clear();
           p.times.clear();
         } else {
           ParameterList key = p.primvars;
           for (float& f : key.find("P")->floats) f += float(r.number(-0.1, 0.1));
           p.motion = {key};
           p.times = {0, 1};
         }
       });
     }},
    {"primvar",
     [](Scene& s, R& r) -> std::string {
       return change(s, r, "primvar", [&](Primitive& p) {
         Parameter v = parameter(r.coin() ? "wear" : "Cs", ValueType::Color, {float(r.number(0, 1)), 0.5f, 0.5f});
         v.storage = StorageClass::Constant;
         p.primvars.set(v);
         return true;
       });
     }},
    {"shape",
     [](Scene& s, R& r) -> std::string {
       return change(s, r, "shape", [&](Primitive& p) {
         const Primitive other = somePrimitive(s, r);
         p.shape = other.shape;
         p.primvars = other.primvars;
         p.motion.clear();
         p.times.clear();
         return true;
       });
     }},
    {"object added",
     [](Scene& s, R& r) -> std::string {
       Primitive p = somePrimitive(s, r);
       if (!s.prototypes.empty() && r.below(3) == 0) {
         p.id = s.nextId++;
         s.prototypes[r.below(s.prototypes.size())].primitives.push_back(std::make_shared<Primitive>(p));
         return "primitive added to an object";
       }
       s.add(p);
       return "object added";
     }},
    {"object removed",
     [](Scene& s, R& r) -> std::string {
       if (s.primitives.size() < 3) return "";
       if (r.coin()) return s.removePrimitive(s.primitives[r.below(s.primitives.size())]->id) ? "object removed" : "";
       s.primitives.erase(s.primitives.begin() + r.below(s.primitives.size()));
       return "object erased";
     }},
    {"objects in another order",
     [](Scene& s, R& r) -> std::string {
       if (s.primitives.size() < 2) return "";
       std::swap(s.primitives[r.below(s.primitives.size())], s.primitives[r.below(s.primitives.size())]);
       return "order";
     }},
    {"object twice",
     [](Scene& s, R& r) -> std::string {
       if (s.primitives.empty()) return "";
       // with the id that the other has
       auto copy = std::make_shared<Primitive>(*s.primitives[r.below(s.primitives.size())]);
       copy->toWorld = moved(copy->toWorld, r);
       s.primitives.push_back(copy);
       return "object twice";
     }},
    {"instance moves",
     [](Scene& s, R& r) -> std::string {
       if (s.instances.empty()) return "";
       const size_t at = r.below(s.instances.size());
       const Instance before = s.instances[at];
       const Transform t = r.below(4) ? moved(before.toWorld, r) : animated(before.toWorld, r);
       if (r.coin())
         s.setInstanceTransform(before.id, t);
       else
         s.instances.edit(at, [&](Instance& i) { i.toWorld = t; });
       return "instance moves";
     }},
    {"instance added",
     [](Scene& s, R& r) -> std::string {
       Instance i;
       i.prototype = uint32_t(r.below(s.prototypes.size() + 1));  // one of them is none
       i.toWorld = moved(Transform(), r);
       s.add(i);
       return "instance added";
     }},
    {"instance removed",
     [](Scene& s, R& r) -> std::string {
       if (s.instances.empty()) return "";
       s.instances.erase(r.below(s.instances.size()));
       return "instance removed";
     }},
    {"nested instance",
     [](Scene& s, R& r) -> std::string {
       if (s.prototypes.size() < 2) return "";
       Prototype& p = s.prototypes.back();
       if (!p.instances.empty() && r.coin()) {
         p.instances.edit(0, [&](Instance& i) { i.toWorld = moved(i.toWorld, r); });
         return "nested instance moves";
       }
       Instance i;
       i.toWorld = moved(Transform(), r);
       p.instances.push_back(i);
       return "nested instance added";
     }},
    {"light in an object",
     [](Scene& s, R& r) -> std::string {
       if (s.prototypes.empty()) return "";
       Prototype& p = s.prototypes[r.below(s.prototypes.size())];
       if (!p.lights.empty() && r.coin()) {
         p.lights.clear();
         return "object's light removed";
       }
       p.lights.push_back(someLight(r));
       return "light in an object";
     }},
    {"objects exchanged",
     [](Scene& s, R&) -> std::string {
       if (s.prototypes.size() < 2) return "";
       std::swap(s.prototypes[0].primitives, s.prototypes[1].primitives);
       return "objects exchanged";
     }},
    {"operation of a solid",
     [](Scene& s, R& r) -> std::string {
       std::vector<Solid*> all;
       for (Solid& one : s.solids) all.push_back(&one);
       for (Prototype& p : s.prototypes)
         for (Solid& one : p.solids) all.push_back(&one);
       if (all.empty()) return "";
       all[r.below(all.size())]->operation = Solid::Operation(r.below(4));
       return "operation of a solid";
     }},
    {"operands of a solid",
     [](Scene& s, R& r) -> std::string {
       if (s.solids.empty() || s.primitives.empty()) return "";
       PrimitivePtr& p = s.primitives[r.below(s.primitives.size())];
       auto edited = std::make_shared<Primitive>(*p);
       // one too many: a solid that is not there
       edited->solid = p->solid ? 0 : uint32_t(r.below(s.solids.size() + 2));
       p = std::move(edited);
       return "operands of a solid";
     }},
    {"coordinate system",
     [](Scene& s, R& r) -> std::string {
       if (s.coordinateSystems.count("mark") && r.below(4) == 0) {
         s.coordinateSystems.erase("mark");
         return "coordinate system removed";
       }
       s.coordinateSystems["mark"] = moved(Transform(), r);
       return "coordinate system";
     }},
    {"any field",
     [](Scene& s, R& r) -> std::string {
       // by the lists of scene/fields.h: whatever there is
       test::Edits edits(s);
       const size_t site = r.below(edits.sites().size());
       const std::string path = edits.sites()[site].path;
       s = edits.edited(s, site);
       return path;
     }},
};

const Kind& kindOf(size_t i) {
  const std::span<const Kind> frames = editsOfFrames(), objects = editsOfObjects();
  return i < frames.size() ? frames[i] : objects[i - frames.size()];
}

}  // namespace

std::span<const Kind> editsOfObjects() { return kKindsOfObjects; }

size_t RandomEdits::kinds() { return editsOfFrames().size() + editsOfObjects().size(); }
const char* RandomEdits::nameOf(size_t kind) { return kindOf(kind).name; }
std::string RandomEdits::apply(scene::Scene& s, size_t kind) { return kindOf(kind).apply(s, *this); }
std::string RandomEdits::apply(scene::Scene& s) {
  for (;;)
    if (std::string done = apply(s, below(kinds())); !done.empty()) return done;
}

}  // namespace kinora::tests
