#include <algorithm>
#include <cctype>
#include <cfloat>
#include <cmath>
#include <string_view>
#include <utility>

#include "rib/archive_search.h"
#include "base/text.h"
#include "rib/interpreter.h"
#include "scene/known_names.h"

namespace kinora::rib {

using scene::Parameter;
using scene::ParameterList;

// Options are frozen at WorldBegin; what comes later had no effect where the scene was made either.
bool Interpreter::optionsAllowed(const Request& r) {
  if (!world_) return true;
  report(Severity::Warning, "RIB-OPTION-IN-WORLD", r.pos, r.name + " stands inside the world", "it is ignored",
         "options must stand before WorldBegin");
  return false;
}

namespace {

using scene::eachName;
using scene::kKnownOptions;
using scene::KnownNames;

// As kKnownOptions: what is misspelt here would be kept and never asked for.
constexpr KnownNames kKnownAttributes[] = {
    {"identifier", "$name $object $lpegroup id id2"},
    {"grouping", "$membership id"},
    {"visibility", "camera indirect transmission"},
    {"trace",
     "maxdiffusedepth maxspeculardepth $reflectsubset $reflectexcludesubset $shadowsubset $shadowexcludesubset "
     "$transmitsubset $transmitexcludesubset holdout intersectpriority displacements bias autobias sssbias "
     "sssautobias samplemotion"},
    {"lighting", "$subset $excludesubset mute"},
    {"lightfilter", "$subset"},
    {"shade", "relativepixelvariance minsamples indexofrefraction faceset"},
    {"dice",
     "micropolygonlength $strategy worlddistancelength $offscreenstrategy offscreenmultiplier rasterorient "
     "watertight pretessellate $referencecamera $referenceinstance minlength $minlengthspace levels roundcurve"},
    {"displacementbound", "sphere $coordinatesystem $CoordinateSystem"},
    {"polygon", "concave smoothnormals smoothdisplacement"},
    {"curve", "opacitysamples widthaffectscurvature"},
    {"procedural", "immediatesubdivide reentrant"},
    {"trimcurve", "$sense"},
    {"volume",
     "$aggregate aggregaterespectvisibility fps shutteroffset velocityshuttercorrection dsominmax dsovelocity "
     "voxelinterpolation"},
    {"Ri", "Sides Matte ReverseOrientation $Orientation falloffpower"},
};
constexpr KnownNames kKnownHider[] = {
    {"raytrace",
     "minsamples maxsamples minextrasamples incremental jitter bluenoise $adaptivemetric adaptall darkfalloff "
     "exposurebracket samplemotion extrememotiondof sampleoffset samplestride decidither geomShadowTermBias "
     "$pixelfiltermode pixelvariance aperture dofaspect shutteropening "
     // of the first years, which asked for what is done anyway
     "$integrationmode $samplemode $depthfilter sigma sigmablur maxvdepth midpointratio mpcache interleavewidth"}};

bool isSameLetter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}
// Whether a slip of the hand makes one word of the other: one letter more, less, another, or two in the wrong order;
// small letters for capitals.
bool isSlip(std::string_view a, std::string_view b) {
  if (a.size() > b.size()) std::swap(a, b);
  if (a.size() < 4 || b.size() - a.size() > 1) return false;
  size_t same = 0;
  while (same < a.size() && isSameLetter(a[same], b[same])) ++same;
  const auto restIsSame = [&](size_t i, size_t k) {
    return a.size() - i == b.size() - k &&
           std::equal(a.begin() + long(i), a.end(), b.begin() + long(k), isSameLetter);
  };
  if (same == a.size()) return true;
  if (a.size() < b.size()) return restIsSame(same, same + 1);
  const bool areSwapped =
      same + 1 < a.size() && isSameLetter(a[same], b[same + 1]) && isSameLetter(a[same + 1], b[same]);
  return restIsSame(same + 1, same + 1) || (areSwapped && restIsSame(same + 2, same + 2));
}

template <size_t N>
bool isKnown(const KnownNames (&known)[N], const std::string& group, const std::string& name) {
  return std::any_of(std::begin(known), std::end(known), [&](const KnownNames& k) {
    return k.group == group && eachName(k.names, [&](std::string_view one, bool) { return one == name; });
  });
}

// What is wrong with a name or the type of its value, as a message's first and last part; "" when nothing is known.
struct Slip {
  std::string what, advice;
};
template <size_t N>
Slip slipOf(const KnownNames (&known)[N], const char* kind, const std::string& group, const Parameter& p) {
  for (const KnownNames& k : known) {
    if (k.group != group) continue;
    Slip slip;
    if (eachName(k.names, [&](std::string_view name, bool isString) {
          if (name != p.name) return false;
          if (isString == (p.type == scene::ValueType::String) || p.isReference) return true;
          // "opaque" and the like of old scenes
          if (name == "transmission") return true;
          slip.what = std::string(kind) + " \"" + group + ":" + p.name + "\" is given as a " +
                      (isString ? "number, and is a string" : "string, and is a number");
          return true;
        }))
      return slip;
    eachName(k.names, [&](std::string_view name, bool) {
      if (!isSlip(p.name, name)) return false;
      slip.what = "there is no " + std::string(kind) + " \"" + group + ":" + p.name + "\"";
      slip.advice = "did you mean \"" + std::string(name) + "\"?";
      return true;
    });
    return slip;
  }
  for (const KnownNames& k : known)
    if (isSlip(group, k.group))
      return {"there is no group \"" + group + "\" of " + kind + "s",
              "did you mean \"" + std::string(k.group) + "\"?"};
  return {};
}

}  // namespace

void Interpreter::tellOfNoEffect(Where where, const std::string& name, const Parameter& p, const SourcePos& pos) {
  static constexpr const char* kKinds[] = {"the hider's parameter", "option", "attribute", "the display's parameter"};
  const char* why = whyNoEffect(where, name, p);
  const std::string what = std::string(kKinds[size_t(where)]) + " \"" + name + "\"";
  if (!why || !keptNames_.insert(what).second) return;
  report(Severity::Warning, "RIB-NO-EFFECT-" + upperCase(name.substr(name.find(':') + 1)), pos,
         what + " has no effect", why);
}

void Interpreter::option(Request& r) {
  Cursor c(r);
  std::string group;
  if (!c.string(group)) return badArguments(r, "a group name");
  const bool always = group == "user" || group == "searchpath" || group == "ribparse" || group == "rib";
  if (!always && !optionsAllowed(r)) return;
  const ParameterList p = parameters(r, c.at, Use::Option);
  auto& options = (world_ ? *world_ : frame_.options).options;
  for (Parameter parameter : p) {
    const std::string name = parameter.name;
    const bool isOther = isKnown(scene::kMoreOptions, group, name);  // and no slip of a name near by
    if (Slip slip = isOther ? Slip() : slipOf(kKnownOptions, "option", group, parameter); !slip.what.empty())
      report(Severity::Warning, "RIB-MISSPELT", r.pos, slip.what, "it has no effect", slip.advice);
    if (group == "searchpath" && name == "dirmap" && !parameter.strings.empty()) {
      parameter.name = "searchpath:dirmap";
      options.set(std::move(parameter));
      useDirmap(&r);
      continue;
    }
    if (group == "searchpath" && !parameter.strings.empty()) {
      // '&' is what stood there before
      const std::string before = options.getString("searchpath:" + name, "");
      for (std::string& s : parameter.strings) {
        s = withEnvironment(s);
        std::string joined;
        for (size_t at = 0; at <= s.size();) {
          const size_t colon = std::min(s.find(':', at), s.size());
          const std::string part = s.substr(at, colon - at);
          const std::string& add = part == "&" ? before : part;
          if (!add.empty()) joined += (joined.empty() ? "" : ":") + add;
          at = colon + 1;
        }
        s = joined;
      }
    }
    if (group == "bucket" && name == "order" && !parameter.strings.empty()) {
      constexpr std::string_view kOrders[] = {"horizontal", "vertical", "zigzag-x", "zigzag-y",
                                              "spacefill",  "random",   "spiral",   "circle"};
      if (const std::string& order = parameter.strings[0];
          std::find(std::begin(kOrders), std::end(kOrders), order) == std::end(kOrders))
        report(Severity::Warning, "RIB-MISSPELT", r.pos,
               "no order of buckets is called \"" + order.substr(0, 40) + "\"", "\"horizontal\" is used",
               "there are horizontal, vertical, zigzag-x, zigzag-y, spacefill, random, spiral and circle");
    }
    tellOfNoEffect(Where::Option, group + ":" + name, parameter, r.pos);
    parameter.name = group + ":" + name;
    options.set(std::move(parameter));
  }
  if (group == "Ri") applyRiOptions(p);
  if (group == "ribparse" || group == "rib")
    if (const Parameter* v = p.find("varsubst"); v && !v->strings.empty()) {
      marker_ = v->strings[0].empty() ? '\0' : v->strings[0][0];
      bareMarker_ = true;
    }
}

// The command line's maps come first, then the scene's. `r` is the request that says them anew.
void Interpreter::useDirmap(const Request* r) {
  dirmap_ = read_.dirmap;
  const std::string text = (world_ ? *world_ : frame_.options).options.getString("searchpath:dirmap", "");
  std::vector<std::pair<std::string, std::string>> own;
  if (readDirmap(text, own))
    dirmap_.insert(dirmap_.end(), own.begin(), own.end());
  else if (r)
    report(Severity::Error, "RIB-DIRMAP", r->pos, "the dirmap \"" + text.substr(0, 80) + "\" cannot be read",
           "it is ignored", "it reads [\"ZONE\" \"FROM\" \"TO\"] any number of times, each quote after a backslash");
}

void Interpreter::applyRiOptions(const ParameterList& p) {
  scene::Scene& s = frame_.options;
  const auto bad = [&](const char* name, const char* wanted) {
    report(Severity::Error, "RIB-ARGUMENTS", p.find(name)->pos,
           "Option \"Ri:" + std::string(name) + "\" needs " + wanted, "it is ignored");
  };
  const auto two = [&](const char* name, auto& a, auto& b) {
    if (const auto v = p.getFloats(name); v.size() >= 2)
      a = std::decay_t<decltype(a)>(v[0]), b = std::decay_t<decltype(b)>(v[1]);
  };
  const auto four = [&](const char* name, std::array<float, 4>& to) {
    if (const auto v = p.getFloats(name); v.size() >= 4) std::copy_n(v.begin(), 4, to.begin());
  };
  if (const Parameter* v = p.find("FormatResolution"))
    for (size_t i = 0; i < 2; ++i) {  // as Format: what is not above 0 stays
      const double n = i < v->ints.size() ? v->ints[i] : i < v->floats.size() ? double(v->floats[i]) : 0;
      if (n > 0) s.resolution[i] = int(std::max(1.0, std::min(n, 2147483647.0)));
    }
  s.pixelAspect = p.getFloat("FormatPixelAspectRatio", s.pixelAspect);
  // -1 is what exporters write where none is meant
  if (const float aspect = p.getFloat("FrameAspectRatio", s.frameAspect); aspect > 0 || aspect == -1)
    s.frameAspect = aspect;
  else if (p.find("FrameAspectRatio"))
    bad("FrameAspectRatio", "a ratio above 0");
  s.pixelVariance = p.getFloat("PixelVariance", s.pixelVariance);
  s.pixelFilter = p.getString("PixelFilterName", s.pixelFilter);
  two("PixelFilterWidth", s.pixelFilterWidth[0], s.pixelFilterWidth[1]);
  std::array<double, 2> shutter = frame_.camera.shutter;
  two("Shutter", shutter[0], shutter[1]);
  if (!(shutter[1] < shutter[0]))
    frame_.camera.shutter = shutter;
  else if (p.find("Shutter"))
    bad("Shutter", "an opening time before the closing time");
  std::array<float, 2> clipping = frame_.camera.clipping;
  two("Clipping", clipping[0], clipping[1]);
  if (clipping[0] < clipping[1])
    frame_.camera.clipping = clipping;
  else if (p.find("Clipping"))
    bad("Clipping", "near below far");
  four("ScreenWindow", frame_.camera.screenWindow);
  four("CropWindow", s.cropWindow);
  if (p.find("Frame")) s.frame = p.getInt("Frame", s.frame);
}

void Interpreter::attribute(Request& r) {
  Cursor c(r);
  std::string group;
  if (!c.string(group)) return badArguments(r, "a group name");
  const ParameterList list = parameters(r, c.at, Use::Attribute);
  if (list.empty()) return;
  scene::Attributes& a = edit();
  using A = scene::Attributes;
  for (Parameter p : list) {
    if (Slip slip = slipOf(kKnownAttributes, "attribute", group, p); !slip.what.empty())
      report(Severity::Warning, "RIB-MISSPELT", r.pos, slip.what, "it has no effect", slip.advice);
    if (group == "Ri") {
      const std::string orientation = p.strings.empty() ? "" : p.strings[0];
      const int value =
          p.ints.empty() ? (p.floats.empty() ? 0 : int(std::max(-1e9f, std::min(1e9f, p.floats[0])))) : p.ints[0];
      using O = scene::Attributes::Orientation;
      if (p.name == "Sides") edit(A::kSides).sides = value == 1 ? 1 : 2;
      if (p.name == "Matte") edit(A::kMatte).matte = value != 0;
      if (p.name == "ReverseOrientation") edit(A::kReverseOrientation).reverseOrientation = value != 0;
      if (p.name == "Orientation") {
        static const std::pair<std::string_view, O> kWords[] = {
            {"outside", O::Outside}, {"inside", O::Inside}, {"lh", O::LeftHanded}, {"rh", O::RightHanded}};
        const auto* word =
            std::find_if(std::begin(kWords), std::end(kWords), [&](const auto& w) { return w.first == orientation; });
        if (word == std::end(kWords)) {
          report(Severity::Error, "RIB-ARGUMENTS", r.pos,
                 "Attribute \"Ri:Orientation\" needs \"outside\", \"inside\", \"lh\" or \"rh\"", "it is ignored");
          continue;
        }
        setOrientation(word->second);
      }
    }
    p.name = group + ":" + p.name;
    tellOfNoEffect(Where::Attribute, p.name, p, r.pos);
    if (p.name == "grouping:membership" && !p.strings.empty() && p.strings[0].starts_with("+")) {
      const std::string before = a.named.getString(p.name, "");
      // in an object with no groups of its own the instance's are added to: the sign stays (scene::inherit)
      if (!before.empty() || openObjects_.empty())
        p.strings[0] = before + (before.empty() ? "" : " ") + p.strings[0].substr(1);
    }
    a.named.set(std::move(p));
  }
}

void Interpreter::format(Request& r) {
  if (!optionsAllowed(r)) return;
  Cursor c(r);
  double v[2], aspect = -1;
  if (!numbers(c, 2, v, "width, height and pixel aspect ratio")) return;
  if (c.at < r.count && !numbers(c, 1, &aspect, "width, height and pixel aspect ratio")) return;
  if (r.count == 1 && r.args[0].exact.size() >= 3) aspect = r.args[0].exact[2];
  for (int i = 0; i < 2; ++i)
    if (v[i] > 0) frame_.options.resolution[size_t(i)] = int(std::max(1.0, std::min(v[i], 2147483647.0)));
  if (aspect > 0 && aspect < FLT_MAX) frame_.options.pixelAspect = float(aspect);
}

void Interpreter::frameAspectRatio(Request& r) {
  Cursor c(r);
  double v;
  if (!optionsAllowed(r) || !numbers(c, 1, &v, "a ratio")) return;
  if (!(v > 0)) return badArguments(r, "a ratio above 0");
  frame_.options.frameAspect = float(v);
}

void Interpreter::screenWindow(Request& r) {
  Cursor c(r);
  double v[4];
  if (!optionsAllowed(r) || !numbers(c, 4, v, "left, right, bottom and top")) return;
  if (v[0] == v[1] || v[2] == v[3]) return badArguments(r, "a window that is not empty");
  std::copy_n(v, 4, frame_.camera.screenWindow.begin());
}

void Interpreter::cropWindow(Request& r) {
  Cursor c(r);
  double v[4];
  if (!optionsAllowed(r) || !numbers(c, 4, v, "xmin, xmax, ymin and ymax")) return;
  for (double& x : v) x = std::max(0.0, std::min(1.0, x));  // an empty window is the renderer's to refuse
  std::copy_n(v, 4, frame_.options.cropWindow.begin());
}

void Interpreter::projection(Request& r) {
  if (!optionsAllowed(r)) return;
  if (r.count == 0) {  // the null projection of the oldest files: what stands in the transform
    frame_.camera.projection = nullptr;
    return;
  }
  frame_.camera.projection = node(r, false);
}

void Interpreter::clipping(Request& r) {
  Cursor c(r);
  double v[2];
  if (!optionsAllowed(r) || !numbers(c, 2, v, "near and far")) return;
  if (!(v[0] < v[1])) return badArguments(r, "near below far");
  frame_.camera.clipping = {float(v[0]), float(v[1])};
}

void Interpreter::clippingPlane(Request& r) {
  Cursor c(r);
  double v[6];
  if (!optionsAllowed(r) || !numbers(c, 6, v, "a point and a normal")) return;
  if (v[3] == 0 && v[4] == 0 && v[5] == 0) return badArguments(r, "a normal that is not zero");
  // said in the space that is being built, which leads to the camera
  const scene::Matrix toCamera = state_.ctm.at(0);
  const Imath::V3d p = Imath::V3d(v[0], v[1], v[2]) * toCamera;
  Imath::V3d n;
  toCamera.inverse().transposed().multDirMatrix(Imath::V3d(v[3], v[4], v[5]), n);
  frame_.camera.clippingPlanes.push_back({p.x, p.y, p.z, n.x, n.y, n.z});
}

void Interpreter::depthOfField(Request& r) {
  if (!optionsAllowed(r)) return;
  if (r.count == 0) {
    frame_.camera.depthOfField = {0, 0, 0};
    return;
  }
  Cursor c(r);
  double v[3];
  if (r.count == 1 && r.args[0].size() == 1) {  // an f-number alone: infinity, i.e. a pinhole
    frame_.camera.depthOfField = {0, 0, 0};
    return;
  }
  if (!c.numbers(3, v)) return badArguments(r, "f-number, focal length and focal distance");
  if (std::isinf(v[0]) || v[0] >= FLT_MAX) {
    frame_.camera.depthOfField = {0, 0, 0};
    return;
  }
  Cursor again(r);
  if (!numbers(again, 3, v, "f-number, focal length and focal distance")) return;
  if (!(v[0] > 0) || !(v[1] > 0) || !(v[2] > 0)) return badArguments(r, "values above 0");
  frame_.camera.depthOfField = {float(v[0]), float(v[1]), float(v[2])};
}

void Interpreter::shutter(Request& r) {
  Cursor c(r);
  double v[2];
  if (!optionsAllowed(r) || !numbers(c, 2, v, "opening and closing time")) return;
  if (v[1] < v[0]) return badArguments(r, "an opening time before the closing time");
  frame_.camera.shutter = {v[0], v[1]};
}

void Interpreter::camera(Request& r) {
  if (!optionsAllowed(r)) return;
  Cursor c(r);
  std::string name;
  if (!c.string(name)) return badArguments(r, "a name");
  scene::Camera camera = frame_.camera;
  camera.name = name;
  camera.worldToCamera = state_.ctm;
  camera.params = parameters(r, c.at, Use::Node);
  camera.pos = r.pos;
  // exporters that speak of each camera apart say its clipping here
  if (camera.params.find("nearClip") || camera.params.find("farClip")) {
    const float near = camera.params.getFloat("nearClip", 0), far = camera.params.getFloat("farClip", FLT_MAX);
    if (near >= 0 && near < far) camera.clipping = {near, far};
  }
  for (scene::Camera& held : frame_.options.cameras)
    if (held.name == name) {
      held = std::move(camera);
      return;
    }
  frame_.options.cameras.push_back(std::move(camera));
}

void Interpreter::pixelFilter(Request& r) {
  Cursor c(r);
  std::string name;
  double w[2];
  if (!optionsAllowed(r)) return;
  if (!c.string(name)) return badArguments(r, "a filter name and two widths");
  if (!numbers(c, 2, w, "a filter name and two widths")) return;
  if (!(w[0] > 0) || !(w[1] > 0)) return badArguments(r, "widths above 0");
  frame_.options.pixelFilter = name;
  frame_.options.pixelFilterWidth = {float(w[0]), float(w[1])};
}

void Interpreter::pixelSamples(Request& r) {
  Cursor c(r);
  double v[2];
  if (!optionsAllowed(r) || !numbers(c, 2, v, "two counts")) return;
  if (!(v[0] >= 1) || !(v[1] >= 1)) return badArguments(r, "counts of at least 1");
  frame_.options.pixelSamples = {int(std::min(v[0], 1e6)), int(std::min(v[1], 1e6))};
}

void Interpreter::pixelVariance(Request& r) {
  Cursor c(r);
  double v;
  if (!optionsAllowed(r) || !numbers(c, 1, &v, "a variance")) return;
  if (v < 0) return badArguments(r, "a variance of at least 0");
  frame_.options.pixelVariance = float(v);
}

void Interpreter::exposure(Request& r) {
  Cursor c(r);
  double v[2];
  if (!optionsAllowed(r) || !numbers(c, 2, v, "gain and gamma")) return;
  if (!(v[0] >= 0) || !(v[1] > 0)) return badArguments(r, "a gain of at least 0 and a gamma above 0");
  frame_.options.exposure = {float(v[0]), float(v[1])};
}

void Interpreter::display(Request& r) {
  if (!optionsAllowed(r)) return;
  Cursor c(r);
  scene::Display d;
  if (!c.string(d.file) || !c.string(d.driver) || !c.string(d.mode))
    return badArguments(r, "a name, a driver and a mode");
  d.params = parameters(r, c.at, Use::Classic);
  d.pos = r.pos;
  for (const Parameter& p : d.params) tellOfNoEffect(Where::Display, p.name, p, r.pos);
  // a name with '+' adds a display, one without replaces all before
  if (d.file.starts_with("+"))
    d.file.erase(0, 1);
  else
    frame_.options.displays.clear();
  frame_.options.displays.push_back(std::move(d));
}

void Interpreter::displayChannel(Request& r) {
  if (!optionsAllowed(r)) return;
  Cursor c(r);
  std::string text;
  if (!c.string(text)) return badArguments(r, "\"type name\"");
  const Declaration* d = declarations_.find(text);
  scene::DisplayChannel channel;
  channel.pos = r.pos;
  if (d) {
    channel.name = d->name;
    channel.type = d->type;
    channel.arrayLength = std::max(1, d->arrayLength);
  } else if (text.find(' ') == std::string::npos && !text.empty()) {
    channel.name = text;
    report(Severity::Warning, "RIB-UNDECLARED", r.pos, "nothing declares the channel \"" + text.substr(0, 60) + "\"",
           "it is read as color");
  } else {
    report(Severity::Error, "RIB-DECLARATION", r.pos,
           "\"" + text.substr(0, 60) + "\" in DisplayChannel is not a declaration", "the channel is ignored",
           "it reads \"type name\", as in \"color Ci\"");
    return;
  }
  channel.params = parameters(r, c.at, Use::Node);
  for (scene::DisplayChannel& held : frame_.options.channels)
    if (held.name == channel.name) {
      held = std::move(channel);
      return;
    }
  frame_.options.channels.push_back(std::move(channel));
}

void Interpreter::hider(Request& r) {
  if (optionsAllowed(r))
    if (auto n = node(r, false, Use::Classic)) {
      for (const Parameter& p : n->params) {
        Slip slip = slipOf(kKnownHider, "parameter", n->plugin, p);
        if (slip.what.empty() && n->plugin == "raytrace" && !isKnown(kKnownHider, n->plugin, p.name) &&
            keptNames_.insert("Hider raytrace:" + p.name).second)
          slip.what = "there is no parameter \"raytrace:" + p.name.substr(0, 60) + "\" of the Hider";
        if (!slip.what.empty())
          report(Severity::Warning, "RIB-MISSPELT", r.pos, slip.what, "it has no effect", slip.advice);
      }
      for (const Parameter& p : n->params) tellOfNoEffect(Where::Hider, p.name, p, r.pos);
      if (const char* why = otherHider(n->plugin); why && keptNames_.insert("Hider " + n->plugin).second)
        report(Severity::Warning, "RIB-NO-EFFECT-HIDER", r.pos, "Hider \"" + n->plugin + "\" is not known here", why);
      frame_.options.hider = n;
    }
}

void Interpreter::integrator(Request& r) {
  if (optionsAllowed(r))
    if (auto n = node(r, true)) frame_.options.integrator = n;
}

namespace {

// Each follows those it refers to; the last one said is the one in force.
void addFilter(std::vector<scene::NodePtr>& filters, const scene::NodePtr& n) {
  std::erase_if(filters, [&](const scene::NodePtr& f) { return f->handle == n->handle; });
  filters.push_back(n);
}

}  // namespace

void Interpreter::sampleFilter(Request& r) {
  if (optionsAllowed(r))
    if (auto n = node(r, true)) addFilter(frame_.options.sampleFilters, n);
}

void Interpreter::displayFilter(Request& r) {
  if (optionsAllowed(r))
    if (auto n = node(r, true)) addFilter(frame_.options.displayFilters, n);
}

namespace {

void setFloats(scene::Node& n, std::string name, scene::ValueType type, std::vector<float> values) {
  scene::Parameter p;
  p.name = std::move(name);
  p.type = type;
  p.floats = std::move(values);
  n.params.set(std::move(p));
}

// A display filter that does what an imager does, of those whose names promise one; null: none does. Colours have the imager's default where nothing is
// said.
std::shared_ptr<scene::Node> filterOfImager(const std::string& imager, const scene::ParameterList& given) {
  using scene::ValueType;
  auto n = std::make_shared<scene::Node>();
  const auto copy = [&](const char* from, const char* to, ValueType type) {
    const size_t count = type == ValueType::Color ? 3 : 1;
    std::vector<float> v = given.getFloats(from);
    const bool isThere = v.size() == count;
    if (isThere) setFloats(*n, to, type, std::move(v));
    return isThere;
  };
  if (imager == "clamp" || imager == "clamptoalpha") {
    n->plugin = "ClampDisplayFilter";
    scene::Parameter mode;
    mode.name = "mode";
    mode.type = ValueType::Int;
    mode.ints = {imager == "clamptoalpha"};
    n->params.set(std::move(mode));
    return n;
  }
  if (imager == "gradient") {
    n->plugin = "GradientDisplayFilter";
    copy("TopColor", "topColor", ValueType::Color);
    copy("BottomColor", "bottomColor", ValueType::Color);
    for (const auto& [from, to] : {std::pair{"Sharpness", "sharpness"},
                                   {"MidPoint", "midPoint"},
                                   {"Frequency", "frequency"},
                                   {"Angle", "angle"}})
      copy(from, to, ValueType::Float);
    return n;
  }
  // RISpec 3.2, appendix A.6: a colour where nothing covers the pixel, which then counts as covered. Exporters bring
  // shaders of their own along that are named after it; what they show without a colour is not known.
  n->plugin = "PxrBackgroundDisplayFilter";
  bool hasColor = false;
  for (const char* from : {"background", "bgcolor", "color"})
    hasColor = copy(from, "backgroundColor", ValueType::Color) || hasColor;
  if (imager != "background" && !hasColor) return nullptr;
  if (!hasColor) setFloats(*n, "backgroundColor", ValueType::Color, {1, 1, 1});
  if (!copy("alpha", "backgroundAlpha", ValueType::Float)) setFloats(*n, "backgroundAlpha", ValueType::Float, {1});
  return n;
}

}  // namespace

// Imagers for which a display filter stands in; the others are told of by name and kept. A DisplayFilter that the scene
// has itself comes after it and is in force.
void Interpreter::imager(Request& r) {
  Request copy = r;
  const std::string imager = r.count > 0 && r.args[0].isString() ? r.args[0].strings[0] : "";
  if (imager.empty() || world_) return keep(r);
  const bool isCandidate = imager == "clamp" || imager == "clamptoalpha" || imager == "gradient" ||
                           lowerCase(imager).ends_with("background");
  // parameters of others are their own business
  const scene::NodePtr given = isCandidate ? node(copy, false, Use::Classic) : nullptr;
  const std::shared_ptr<scene::Node> n = given ? filterOfImager(imager, given->params) : nullptr;
  auto& filters = frame_.options.displayFilters;
  std::erase_if(filters, [](const scene::NodePtr& f) { return f->handle == "Imager"; });  // the last one is in force
  if (!n) return keep(r);
  keepQuietly(r);
  n->kind = "DisplayFilter";
  n->handle = "Imager";
  n->pos = copy.pos;
  filters.insert(filters.begin(), n);
}

}  // namespace kinora::rib
