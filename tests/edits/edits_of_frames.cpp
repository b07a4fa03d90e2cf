#include "tests/edits/edit_kinds.h"

namespace kinora::tests {

namespace {

const Kind kKindsOfFrames[] = {
    {"camera moves",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       Camera c = s.cameras[0];
       c.worldToCamera = moved(c.worldToCamera, r);
       s.setCamera(0, c);
       return "camera";
     }},
    {"camera goes far",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       Matrix m;
       m.setTranslation(Imath::V3d(r.number(-5000, 5000), 0, r.coin() ? 3000 : 0));
       s.cameras[0].worldToCamera = concat(Transform::fixed(m), s.cameras[0].worldToCamera);
       for (PrimitivePtr& p : s.primitives) {
         auto copy = std::make_shared<Primitive>(*p);
         copy->toWorld = concat(copy->toWorld, Transform::fixed(m.inverse()));
         p = copy;
       }
       return "camera and objects go far";
     }},
    {"camera animated",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       s.cameras[0].worldToCamera = animated(s.cameras[0].worldToCamera, r);
       return "camera animated";
     }},
    {"shutter",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       s.cameras[0].shutter = {r.coin() ? 0.0 : 0.25, r.coin() ? r.number(0.3, 1) : 0.0};
       return "shutter";
     }},
    {"lens",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       s.cameras[0].depthOfField = {float(r.number(0.5, 4)), 0.5f, float(r.number(3, 7))};
       if (s.cameras[0].projection)
         s.cameras[0].projection =
             with(s.cameras[0].projection, parameter("fov", ValueType::Float, {float(r.number(30, 70))}));
       return "lens";
     }},
    {"projection",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       if (r.coin())
         s.cameras[0].projection = nullptr;
       else
         s.cameras[0].projection = node("Projection", r.coin() ? "PxrCamera" : "perspective", "eye");
       return "projection";
     }},
    {"clipping",
     [](Scene& s, R& r) -> std::string {
       if (s.cameras.empty()) return "";
       if (r.coin())
         s.cameras[0].clippingPlanes.push_back({0, 0, r.number(4, 7), 0, 0.2, 1});
       else
         s.cameras[0].clipping = {float(r.number(0.1, 5)), 100};
       return "clipping";
     }},
    {"resolution",
     [](Scene& s, R& r) -> std::string {
       s.resolution = {int(12 + r.below(12)), int(8 + r.below(8))};
       if (r.coin()) s.pixelAspect = float(r.number(0.8, 1.2));
       return "resolution";
     }},
    {"crop",
     [](Scene& s, R& r) -> std::string {
       s.cropWindow = {float(r.number(0, 0.4)), float(r.number(0.6, 1)), 0, float(r.number(0.5, 1))};
       return "crop window";
     }},
    {"pixel filter",
     [](Scene& s, R& r) -> std::string {
       static const char* const kNames[] = {"box", "gaussian", "mitchell", "separable-catmull-rom", "sinc"};
       s.pixelFilter = kNames[r.below(std::size(kNames))];
       s.pixelFilterWidth = {float(r.number(1, 3)), float(r.number(1, 3))};
       return "pixel filter " + s.pixelFilter;
     }},
    {"hider",
     [](Scene& s, R& r) -> std::string {
       if (!s.hider) return "";
       const int which = int(r.below(4));
       s.hider = with(s.hider, which == 0   ? integer("jitter", int(r.below(2)))
                               : which == 1 ? integer("maxsamples", 1 + int(r.below(4)))
                               : which == 2 ? integer("geomShadowTermBias", int(r.below(2)))
                                            : integer("sampleoffset", int(r.below(3))));
       return "hider " + std::to_string(which);
     }},
    {"option",
     [](Scene& s, R& r) -> std::string {
       s.options.set(integer("limits:gridsize", int(r.below(100))));
       s.options.set(text("bucket:order", r.coin() ? "spiral" : "vertical"));
       return "options";
     }},
    {"lobe option",
     [](Scene& s, R& r) -> std::string {
       s.options.set(text(r.coin() ? "lpe:diffuse2" : "lpe:specular2", r.coin() ? "Diffuse" : "Specular"));
       return "lobe option";
     }},
    {"integrator",
     [](Scene& s, R& r) -> std::string {
       static const char* const kNames[] = {"PxrPathTracer", "PxrDirectLighting", "PxrOcclusion",
                                            "PxrVisualizer", "PxrDefault",        "NoSuchIntegrator"};
       if (s.integrator && r.coin())
         s.integrator = with(s.integrator, integer("maxIndirectBounces", int(r.below(4))));
       else
         s.integrator = node("Integrator", kNames[r.below(std::size(kNames))], "loop");
       return "integrator " + (s.integrator ? s.integrator->plugin : "");
     }},
    {"channel added",
     [](Scene& s, R& r) -> std::string {
       if (s.displays.empty()) return "";
       static const char* const kSources[] = {"lpe:C<RD>L", "lpe:C.*[LO]",           "st",
                                              "wear",       "lpe:C<RS>.*<L.'warm'>", "z"};
       DisplayChannel c;
       c.name = "more" + std::to_string(r.below(3));
       c.params.set(text("source", kSources[r.below(std::size(kSources))]));
       s.channels.push_back(c);
       s.displays[0].mode += "," + c.name;
       return "channel";
     }},
    {"channel removed",
     [](Scene& s, R&) -> std::string {
       if (s.displays.empty()) return "";
       const size_t comma = s.displays[0].mode.rfind(',');
       if (comma == std::string::npos) return "";
       s.displays[0].mode.resize(comma);
       return "channel removed";
     }},
    {"sample filter",
     [](Scene& s, R& r) -> std::string {
       if (!s.sampleFilters.empty() && r.coin()) {
         s.sampleFilters.clear();
         return "sample filter removed";
       }
       auto n = std::make_shared<Node>(*node("SampleFilter", "PxrGradeSampleFilter", "grade"));
       n->params.set(parameter("gain", ValueType::Color, {float(r.number(0.5, 2)), 1, 1}));
       s.sampleFilters = {n};
       return "sample filter";
     }},
    {"light parameter",
     [](Scene& s, R& r) -> std::string {
       if (s.lights.empty()) return "";
       Light l = s.lights[r.below(s.lights.size())];
       if (!l.node) return "";
       const int which = int(r.below(5));
       l.node =
           with(l.node, which == 0   ? parameter("intensity", ValueType::Float, {float(r.number(0.1, 8))})
                        : which == 1 ? parameter("lightColor", ValueType::Color, {1, 0.5f, float(r.number(0, 1))})
                        : which == 2 ? parameter("diffuse", ValueType::Float, {float(r.number(0.1, 2))})
                        : which == 3 ? integer("enableShadows", int(r.below(2)))
                                     : text("lightGroup", r.coin() ? "warm" : "cold"));
       const uint32_t id = l.id;
       const std::string done = "light " + l.node->handle + " parameter " + std::to_string(which);
       if (r.coin())
         s.setLight(id, l);
       else
         for (Light& held : s.lights)
           if (held.id == id) held.node = l.node;
       return done;
     }},
    {"light moves",
     [](Scene& s, R& r) -> std::string {
       if (s.lights.empty()) return "";
       Light& l = s.lights[r.below(s.lights.size())];
       l.toWorld = r.below(4) ? moved(l.toWorld, r) : animated(l.toWorld, r);
       return "light moves";
     }},
    {"light's attributes",
     [](Scene& s, R& r) -> std::string {
       if (s.lights.empty()) return "";
       Light& l = s.lights[r.below(s.lights.size())];
       auto a = std::make_shared<Attributes>(l.attributes ? *l.attributes : Attributes());
       const int which = int(r.below(4));
       a->named.set(which == 0   ? integer("visibility:camera", int(r.below(2)))
                    : which == 1 ? integer("visibility:indirect", int(r.below(2)))
                    : which == 2 ? integer("lighting:mute", int(r.below(2)))
                                 : text("grouping:membership", r.coin() ? "lamps" : "others"));
       l.attributes = a;
       return "light's attribute " + std::to_string(which);
     }},
    {"light's filter",
     [](Scene& s, R& r) -> std::string {
       if (s.lights.empty()) return "";
       Light& l = s.lights[r.below(s.lights.size())];
       if (!l.filters.empty() && r.coin()) {
         l.filters.clear();
         l.filterToWorld.clear();
         return "light's filter removed";
       }
       auto n = std::make_shared<Node>(*node("LightFilter", "PxrIntMultLightFilter", "dim"));
       n->params.set(parameter("intensity", ValueType::Float, {float(r.number(0.2, 1.5))}));
       l.filters = {n};
       l.filterToWorld = {Transform()};
       return "light's filter";
     }},
    {"light's map",
     [](Scene& s, R& r) -> std::string {
       static const char* const kFiles[] = {"sky.png", "wood.png", "none.png", ""};
       for (Light& l : s.lights)
         if (l.node && l.node->plugin == "PxrDomeLight") {
           l.node = with(l.node, text("lightColorMap", kFiles[r.below(std::size(kFiles))]));
           return "light's map";
         }
       return "";
     }},
    {"light's geometry",
     [](Scene& s, R& r) -> std::string {
       for (Light& l : s.lights)
         if (l.geometry) {
           if (Parameter* p = l.geometry->primvars.find("P"); p && !p->floats.empty())
             p->floats[r.below(p->floats.size())] += float(r.number(-0.3, 0.3));
           return "light's geometry";
         }
       return "";
     }},
    {"light added",
     [](Scene& s, R& r) -> std::string {
       const Light l = someLight(r);
       s.add(l);
       return "light added: " + l.node->plugin;
     }},
    {"light removed",
     [](Scene& s, R& r) -> std::string {
       if (s.lights.empty()) return "";
       s.lights.erase(s.lights.begin() + r.below(s.lights.size()));
       return "light removed";
     }},
    {"old light",
     [](Scene& s, R& r) -> std::string {
       if (!s.classicLights.empty() && r.coin()) {
         s.classicLights.pop_back();
         return "old light removed";
       }
       Light l;
       auto n = std::make_shared<Node>();
       n->kind = "LightSource";
       n->plugin = r.coin() ? "pointlight" : "ambientlight";
       n->handle = "old" + std::to_string(s.nextId);
       n->params.set(parameter("intensity", ValueType::Float, {float(r.number(1, 5))}));
       l.node = n;
       l.id = s.nextId++;
       s.classicLights.push_back(l);
       return "old light " + n->plugin;
     }},
    {"old lights listed",
     [](Scene& s, R& r) -> std::string {
       return changeAttributes(s, r, "light sources", [&](Attributes& a) {
         std::vector<uint32_t> ids;
         for (const Light& l : s.classicLights)
           if (r.coin()) ids.push_back(l.id);
         a.lightSources = std::make_shared<const std::vector<uint32_t>>(std::move(ids));
         return true;
       });
     }},
};

}  // namespace

std::span<const Kind> editsOfFrames() { return kKindsOfFrames; }

}  // namespace kinora::tests
