#include "rib/named_values.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "rib/condition.h"

namespace kinora::rib {

namespace {

using scene::Attributes;
using scene::Camera;
using scene::Scene;
using NamedValue = std::optional<std::string>;  // empty: not said

template <class Numbers>
std::string numbersOf(const Numbers& numbers) {
  std::string s;
  for (const auto n : numbers) s += (s.empty() ? "" : " ") + plainText(n);
  return s;
}
std::string numbersOf(const std::array<double, 2>& v) { return numbersOf(std::array{float(v[0]), float(v[1])}); }

// What requests set beside the lists of attributes and options. Attribute "Ri" and Option "Ri" set the same, so that
// these are asked before the lists, which know nothing of requests that came later.
struct ClassicAttribute {
  std::string_view name;
  NamedValue (*value)(const Attributes&, bool isMirrored);
};
NamedValue orientationOf(const Attributes& a, bool isMirrored) {
  static constexpr const char* kWords[] = {"outside", "inside", "lh", "rh"};
  if (!a.says(Attributes::kOrientation)) return std::nullopt;
  const size_t word = size_t(a.orientation);
  return kWords[isMirrored && word > 1 ? 5 - word : word];
}
constexpr ClassicAttribute kClassicAttributes[] = {
    {"Ri:Color", [](const Attributes& a, bool) { return a.color ? NamedValue(numbersOf(*a.color)) : NamedValue(); }},
    {"Ri:Matte", [](const Attributes& a,
                    bool) { return a.says(Attributes::kMatte) ? NamedValue(a.matte ? "1" : "0") : NamedValue(); }},
    {"Ri:Opacity",
     [](const Attributes& a, bool) { return a.opacity ? NamedValue(numbersOf(*a.opacity)) : NamedValue(); }},
    {"Ri:Orientation", orientationOf},
    {"Ri:ReverseOrientation",
     [](const Attributes& a, bool) {
       const bool isSaid = a.reverseOrientation || a.says(Attributes::kReverseOrientation);
       return isSaid ? NamedValue(a.reverseOrientation ? "1" : "0") : NamedValue();
     }},
    {"Ri:ShadingInterpolation",
     [](const Attributes& a, bool) {
       return a.says(Attributes::kShadingInterpolation) ? NamedValue(a.smoothShading ? "smooth" : "constant")
                                                        : NamedValue();
     }},
    {"Ri:ShadingRate",
     [](const Attributes& a, bool) {
       return a.says(Attributes::kShadingRate) ? NamedValue(plainText(a.shadingRate)) : NamedValue();
     }},
    {"Ri:Sides", [](const Attributes& a,
                    bool) { return a.says(Attributes::kSides) ? NamedValue(plainText(a.sides)) : NamedValue(); }},
    {"Ri:TextureCoordinates",
     [](const Attributes& a, bool) {
       return a.says(Attributes::kTextureCoordinates) ? NamedValue(numbersOf(a.textureCoordinates)) : NamedValue();
     }},
};

struct ClassicOption {
  std::string_view name;
  NamedValue (*value)(const Scene&, const Camera&);
};
std::array<int, 2> resolutionOf(const Scene& s) {
  return {s.resolution[0] > 0 ? s.resolution[0] : 640, s.resolution[1] > 0 ? s.resolution[1] : 480};
}
// The shorter side of the frame spans -1 to 1.
std::array<float, 4> screenWindowOf(const Scene& s, const Camera& c) {
  if (c.screenWindow != std::array<float, 4>{0, 0, 0, 0}) return c.screenWindow;
  const std::array<int, 2> size = resolutionOf(s);
  const float aspect =
      s.frameAspect > 0 ? s.frameAspect : float(size[0]) / float(size[1]) * (s.pixelAspect > 0 ? s.pixelAspect : 1);
  const float x = std::max(aspect, 1.f), y = aspect < 1 ? 1 / aspect : 1;
  return {-x, x, -y, y};
}
constexpr ClassicOption kClassicOptions[] = {
    {"Ri:Clipping",
     [](const Scene&, const Camera& c) {
       return c.clipping[1] > c.clipping[0] ? NamedValue(numbersOf(c.clipping)) : NamedValue();
     }},
    {"Ri:CropWindow", [](const Scene& s, const Camera&) { return NamedValue(numbersOf(s.cropWindow)); }},
    {"Ri:Exposure", [](const Scene& s, const Camera&) { return NamedValue(numbersOf(s.exposure)); }},
    {"Ri:FormatPixelAspectRatio", [](const Scene& s, const Camera&) { return NamedValue(plainText(s.pixelAspect)); }},
    {"Ri:FormatResolution", [](const Scene& s, const Camera&) { return NamedValue(numbersOf(resolutionOf(s))); }},
    {"Ri:Frame",
     [](const Scene& s, const Camera&) { return s.hasFrame ? NamedValue(plainText(s.frame)) : NamedValue(); }},
    {"Ri:FrameAspectRatio", [](const Scene& s, const Camera&) { return NamedValue(plainText(s.frameAspect)); }},
    {"Ri:PixelFilterName", [](const Scene& s, const Camera&) { return NamedValue(s.pixelFilter); }},
    {"Ri:PixelFilterWidth", [](const Scene& s, const Camera&) { return NamedValue(numbersOf(s.pixelFilterWidth)); }},
    {"Ri:PixelSamples",
     [](const Scene& s, const Camera&) {
       return s.pixelSamples[0] ? NamedValue(numbersOf(s.pixelSamples)) : NamedValue();
     }},
    // none said: samples do not adapt, as with 0
    {"Ri:PixelVariance",
     [](const Scene& s, const Camera&) { return NamedValue(plainText(std::max(s.pixelVariance, 0.f))); }},
    {"Ri:ScreenWindow", [](const Scene& s, const Camera& c) { return NamedValue(numbersOf(screenWindowOf(s, c))); }},
    {"Ri:Shutter", [](const Scene&, const Camera& c) { return NamedValue(numbersOf(c.shutter)); }},
};

// "name value" of a group, parted by '|'; a value may be nothing or several numbers. They are those that the RenderMan
// documentation gives, as scenes compare with them, whatever this renderer makes of sizes of buffers and caches.
struct Usual {
  std::string_view group, values;
};
constexpr Usual kUsualAttributes[] = {
    {"Ri",
     "Color 1 1 1|Opacity 1 1 1|Sides 2|Matte 0|Orientation outside|ReverseOrientation 0|ShadingRate 1|"
     "ShadingInterpolation smooth|TextureCoordinates 0 0 1 0 0 1 1 1|GeometricApproximationFocusFactor 1"},
    {"curve", "opacitysamples 0|widthaffectscurvature 1"},
    {"derivatives", "extrapolate 1"},
    {"dice",
     "micropolygonlength 1|strategy instanceprojection|worlddistancelength -1|offscreenstrategy "
     "viewfrustumdistance|offscreenmultiplier -1|rasterorient 1|watertight 0|pretessellate 1|referencecamera |"
     "referenceinstance |minlength -1|minlengthspace "},
    {"displacement", "ignorereferenceinstance 0"},
    {"displacementbound", "sphere 0|CoordinateSystem object|coordinatesystem object|offscreen 0"},
    {"grouping", "membership |id 0"},
    {"identifier", "name |object |id 0|id2 0|lpegroup "},
    {"lightfilter", "subset "},
    {"lighting", "subset |excludesubset |mute 0"},
    {"polygon", "concave 1|smoothnormals 0|smoothdisplacement 0"},
    {"procedural", "immediatesubdivide 0|reentrant 0"},
    {"shade", "relativepixelvariance 1|minsamples 1|indexofrefraction -1"},
    {"trace",
     "maxdiffusedepth 1|maxspeculardepth 2|reflectsubset |reflectexcludesubset |shadowsubset |shadowexcludesubset |"
     "transmitsubset |transmitexcludesubset |holdout 0|intersectpriority 0|displacements 1|bias 0.01|autobias 1|"
     "sssbias 0.0001|sssautobias 1|samplemotion 1"},
    {"trimcurve", "sense inside"},
    {"visibility", "camera 1|indirect 1|transmission 1"},
    {"volume",
     "aggregate globalVolumeAggregate|aggregaterespectvisibility 1|fps 1|shutteroffset 1|"
     "velocityshuttercorrection 0|dsominmax 1|dsovelocity 0"},
};
constexpr Usual kUsualOptions[] = {
    {"bucket", "order horizontal|orderorigin 0 0"},
    {"checkpoint", "interval |exitat |command |keepfiles 0|asfinal 0"},
    {"curve", "minwidth 0"},
    {"deep", "flagvolumes 1"},
    {"dice", "offscreenmultiplier 1"},
    {"lighting", "minimumestimate 0.000001|selectionlearningscheme 1"},
    {"limits",
     "bucketsize 16 16|gridsize 289|shadesize 289|threads 0|texturememory 2097152|textureperthreadmemoryratio 0.5|"
     "geocachememory 2097152|opacitycachememory 1048576|ptexturememory 32768|ptexturemaxfiles 128|brickmemory "
     "2097152|"
     "octreememory 20480|pointmemory 20480|matrixcachememory 0|rendermemory 0|rendertime 0|deepshadowerror 0.01|"
     "nurbcurvaturedicefactor 3|proceduralbakingclumpsize 0"},
    {"lpe",
     "diffuse2 Diffuse,HairDiffuse,diffuse,translucent,hair4,irradiance|diffuse3 Subsurface,subsurface|"
     "specular2 Specular,HairSpecularR,specular,hair1|specular3 RoughSpecular,HairSpecularTRT,hair3|"
     "specular4 Clearcoat|specular5 Iridescence|specular6 Fuzz,HairSpecularGLINTS|"
     "specular7 SingleScatter,HairSpecularTT,hair2|specular8 Glass,specular|"
     "user2 Albedo,DiffuseAlbedo,SubsurfaceAlbedo,HairAlbedo|user3 |user4 |user5 |user6 |user7 |user8 |user9 |"
     "user10 |user11 |user12 "},
    {"osl", "batched 1|verbose 4|statisticslevel 0"},
    {"rib", "format ascii|compression none"},
    {"shade",
     "roughnessmollification 1|shadowBumpTerminator 1|debug 0|subsurfaceTypeDefaultFromVersion24 0|"
     "chiangCompatibilityVersion 24"},
    {"shutter", "offset 0"},
    {"statistics", "level 0|xmlfilename |filename |jsonFilename |maxdispwarnings 100|texturestatslevel 0"},
    {"stitch", "refwarning 1"},
    {"trace",
     "bvhcompression 0|worldorigin camera|worldoffset 0 0 0|incorrectCurveBias 0|maxdepth 10|decimationrate 1"},
    {"volume", "aggregatespace world"},
};

template <size_t N>
NamedValue usualOf(const Usual (&all)[N], std::string_view name) {
  const size_t colon = name.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const std::string_view group = name.substr(0, colon);
  name.remove_prefix(colon + 1);
  for (const Usual& u : all) {
    if (u.group != group) continue;
    for (std::string_view rest = u.values; !rest.empty();) {
      const size_t end = std::min(rest.find('|'), rest.size()), blank = rest.find(' ');
      if (rest.substr(0, blank) == name) return std::string(rest.substr(blank + 1, end - blank - 1));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return std::nullopt;
}

template <class Entries>
auto* entryOf(const Entries& entries, std::string_view name) {
  const auto it = std::find_if(std::begin(entries), std::end(entries), [&](const auto& e) { return e.name == name; });
  return it == std::end(entries) ? nullptr : &*it;
}

}  // namespace

std::optional<std::string> attributeValue(std::string_view name, const Attributes& a, bool isMirrored) {
  if (const auto* classic = entryOf(kClassicAttributes, name))
    if (NamedValue v = classic->value(a, isMirrored)) return v;
  const scene::Parameter* p = a.named.find(name);
  return p ? NamedValue(plainText(*p)) : NamedValue();
}

std::optional<std::string> optionValue(std::string_view name, const Scene& options, const Camera& camera) {
  if (const auto* classic = entryOf(kClassicOptions, name))
    if (NamedValue v = classic->value(options, camera)) return v;
  const scene::Parameter* p = options.options.find(name);
  return p ? NamedValue(plainText(*p)) : NamedValue();
}

std::optional<std::string> usualAttribute(std::string_view name) { return usualOf(kUsualAttributes, name); }
std::optional<std::string> usualOption(std::string_view name) { return usualOf(kUsualOptions, name); }

}  // namespace kinora::rib
