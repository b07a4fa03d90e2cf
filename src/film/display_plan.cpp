#include "film/display_plan.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <utility>

#include "base/text.h"
#include "film/display_channels.h"
#include "film/display_modes.h"
#include "film/light_paths.h"
#include "image/read_write.h"

namespace kinora::film {
namespace {

// The driver that writes files of an extension; "" when none does.
std::string driverOfExtension(const std::string& extension) {
  if (extension == "exr") return "openexr";
  if (extension == "png") return "png";
  if (extension == "tif" || extension == "tiff") return "tiff";
  if (extension == "jpg" || extension == "jpeg") return "jpeg";
  for (const char* e : {"tga", "hdr", "bmp", "ppm"})
    if (extension == e) return kImageWriter;
  return "";
}

// Drivers of other renderers that mean a picture format; "" for any other.
std::string extensionOfDriver(const std::string& driver) {
  static const std::map<std::string, std::string> table{{"tiff", "tif"},    {"tif", "tif"}, {"targa", "tga"},
                                                        {"jpeg", "jpg"},    {"jpg", "jpg"}, {"exr", "exr"},
                                                        {"openexr", "exr"}, {"png", "png"}};
  const auto it = table.find(driver);
  return it == table.end() ? "" : it->second;
}

// Fills in `file` and `driver`. False: the display is not written.
bool chooseDriver(const scene::Display& display, const DriverLookup& lookup, Diagnostics& diagnostics, Output& out) {
  std::string driver = lowerCase(display.driver);
  if (driver.starts_with("d_")) driver = driver.substr(2);
  if (driver == "null") return false;
  const std::string extension = image::extensionOf(out.file);
  const std::string wanted = extensionOfDriver(driver);
  if (!wanted.empty()) {
    // the driver's word counts; a name without its extension gets it, so that every program can open the file
    if (driverOfExtension(extension) != driverOfExtension(wanted) || extension.empty()) out.file += "." + wanted;
    out.driver = driverOfExtension(wanted);
    return true;
  }
  if (lookup && lookup(driver)) {
    out.driver = driver;
    return true;
  }
  out.driver = driverOfExtension(extension);
  if (out.driver.empty()) {
    out.file += ".exr";
    out.driver = "openexr";
  }
  // "file" is RIB's word for "the usual format"; programs that showed pictures in windows are not missed
  static constexpr std::array kWindows{"framebuffer", "it",      "rgbframebuffer", "zframebuffer",
                                       "x11",         "windows", "houdini"};
  if (std::find(kWindows.begin(), kWindows.end(), driver) != kWindows.end())
    diagnostics.info("DISPLAY-DRIVER", display.pos,
                     "display \"" + display.driver + "\" shows no window here: \"" + out.file + "\" is written");
  else if (driver != "file" && driver != kImageWriter && !driver.empty())
    diagnostics.warning("DISPLAY-DRIVER", display.pos, "display driver \"" + display.driver + "\" is not known",
                        "\"" + out.file + "\" is written");
  return true;
}

std::vector<std::string> floatNames(const std::string& prefix, const Channel& channel) {
  static constexpr std::array kColor{"R", "G", "B", "A"}, kPoint{"X", "Y", "Z", "W"};
  if (channel.width == 1) return {prefix};
  std::vector<std::string> names;
  for (int k = 0; k < channel.width; ++k)
    names.push_back((prefix.empty() ? "" : prefix + ".") +
                    (channel.type == ChannelType::Color ? kColor[size_t(k)] : kPoint[size_t(k)]));
  return names;
}

// Light paths go to pixels as they are, by a box filter: channels that choose among samples cannot have them.
bool takesSplats(const Channel& c, const scene::Display& display, const PlanOptions& options,
                 Diagnostics& diagnostics) {
  std::array<float, 3> remap;
  if (!options.splats || c.width != 3 || !LightPaths::knows(sourceBehind(c.source, remap))) return false;
  const bool takes = (c.reducer == Reducer::Sum || c.reducer == Reducer::Average) && c.half == Half::Both &&
                     c.statistic == Statistic::Value && !c.isRemapped();
  if (!takes)
    diagnostics.warning("DISPLAY-CHANNEL-SPLATS", display.pos,
                        "channel \"" + c.name + "\" cannot take light that paths from the lights bring",
                        "it holds the camera's paths alone",
                        "filter \"filter\" or \"average\" without statistics and remap takes it");
  return takes;
}

// The channels of one display as the film sums them and as the file names them.
void addChannels(const scene::Scene& scene, const scene::Display& display, const PlanOptions& options,
                 DisplayPlan& plan, Output& out, Diagnostics& diagnostics) {
  const bool asRgba = display.params.getInt("asrgba", 1) != 0;
  const std::string colour = display.params.getString("asrgbacolorchannel", "");
  const std::string alpha = display.params.getString("asrgbaalphachannel", "");
  std::vector<std::string> taken;
  for (const ModeChannel& wanted : channelsOfMode(scene, display)) {
    const std::string& name = wanted.name;
    int index = plan.layout.find(name);
    // what is wrong with a channel has been said when it was first asked for
    Diagnostics silent([](const std::string&, Severity) {});
    Diagnostics& messages = index >= 0 ? silent : diagnostics;
    Channel c = describeChannel(scene, wanted, display, messages);
    c.splats = takesSplats(c, display, options, messages);
    // sample filters change what stands in records, of the channels that they name alone
    std::array<float, 3> remap;
    if (!scene.sampleFilters.empty() && c.source != c.name && LightPaths::knows(sourceBehind(c.source, remap)))
      c.source = ownSource(c.name, c.source);
    std::string error;
    // a display with a filter of its own sums its channels apart from those of others
    while (index >= 0 && !(plan.layout[index] == c)) {
      c.name += "'";
      index = plan.layout.find(c.name);
    }
    if (index < 0) index = plan.layout.add(c, &error);
    if (index < 0) {
      diagnostics.warning("DISPLAY-CHANNEL", display.pos,
                          "channel \"" + name + "\" of \"" + out.file + "\": " + error, "left out");
      continue;
    }
    const Channel& summed = plan.layout[index];
    OutputChannel o;
    o.channel = index;
    o.isColor = summed.type == ChannelType::Color && !summed.isData;
    const auto declared = std::find_if(scene.channels.rbegin(), scene.channels.rend(),
                                       [&](const scene::DisplayChannel& d) { return d.name == name; });
    o.values =
        displayValues(scene.exposure, display.params, declared == scene.channels.rend() ? nullptr : &declared->params,
                      name, display.pos, diagnostics);
    if (asRgba && summed.width == 3 && name == (colour.empty() ? "Ci" : colour))
      o.names = {"R", "G", "B"};
    else if (asRgba && summed.width == 1 && name == (alpha.empty() ? "a" : alpha))
      o.names = {"A"};
    else if (asRgba && name == "z")
      o.names = {"Z"};
    else
      o.names = floatNames(name, summed);
    if (std::any_of(o.names.begin(), o.names.end(),
                    [&](auto& n) { return std::find(taken.begin(), taken.end(), n) != taken.end(); }))
      continue;  // listed twice
    taken.insert(taken.end(), o.names.begin(), o.names.end());
    out.channels.push_back(std::move(o));
  }
}

bool hasBeauty(const scene::Scene& scene, const scene::Display& d) {
  const auto names = channelsOfMode(scene, d);
  return std::any_of(names.begin(), names.end(), [](const ModeChannel& c) { return c.name == "Ci"; });
}

// Drivers of other renderers that show a picture in a window. Kinora writes a file in its place.
bool isWindow(const scene::Display& d) {
  const std::string driver = lowerCase(d.driver);
  for (const char* w : {"framebuffer", "rgbframebuffer", "it", "x11", "piqsl", "sho", "windows", "houdini", "mplay"})
    if (driver == w || driver == std::string("d_") + w) return true;
  return false;
}

bool isNull(const scene::Display& d) { return lowerCase(d.driver) == "null" || lowerCase(d.driver) == "d_null"; }

std::string asOneName(const std::string& file) { return std::filesystem::path(file).lexically_normal().string(); }

// The displays of the scene; the primary one, which -o means, is first told by `primary` (past the end: there is
// none). The reader has applied RIB's "+" (add) and its absence (replace); a "+" that a scene made otherwise still
// holds is dropped.
std::vector<scene::Display> wantedDisplays(const scene::Scene& scene, size_t& primary) {
  std::vector<scene::Display> list;
  for (scene::Display d : scene.displays) {
    if (d.file.starts_with("+")) d.file = d.file.substr(1);
    if (d.file.empty()) d.file = "untitled";
    list.push_back(std::move(d));
  }
  // a window beside a file of one name, or a second window: one picture is enough
  for (size_t i = 0; i < list.size();) {
    const auto isOther = [&](const scene::Display& d) {
      return &d != &list[i] && !isNull(d) && asOneName(d.file) == asOneName(list[i].file) &&
             (!isWindow(d) || &d < &list[i]);
    };
    if (isWindow(list[i]) && std::any_of(list.begin(), list.end(), isOther))
      list.erase(list.begin() + ptrdiff_t(i));
    else
      ++i;
  }
  primary =
      size_t(std::find_if(list.begin(), list.end(), [&](auto& d) { return hasBeauty(scene, d); }) - list.begin());
  return list;
}

scene::Display beautyFor(const scene::Scene& scene) { return {{}, {}, "rgba", {}, scene.pos}; }

// The driver by the file's extension; a file of no picture format gets one.
void directTo(Output& out, const std::string& file, Diagnostics& diagnostics) {
  out.file = file;
  out.driver = driverOfExtension(image::extensionOf(file));
  if (!out.driver.empty()) return;
  diagnostics.warning("DISPLAY-EXTENSION", out.pos, "the extension of \"" + file + "\" names no picture format",
                      "\"" + file + ".exr\" is written", "use .exr, .png, .tif or .jpg");
  out.file += ".exr";
  out.driver = "openexr";
}

// Two pictures onto one file: the second would take the place of the first.
void checkFiles(DisplayPlan& plan, Diagnostics& diagnostics) {
  if (!plan.isWritable) return;  // told
  std::map<std::string, const Output*> byName;
  for (const Output& o : plan.outputs) {
    const auto [it, isNew] = byName.try_emplace(asOneName(o.file), &o);
    if (isNew) continue;
    plan.isWritable = false;
    diagnostics.error("DISPLAY-SAME-FILE", o.pos, "two displays would be written to \"" + o.file + "\"",
                      "nothing is rendered or written", "name a file for each of them");
  }
}

}  // namespace

std::string fillFrame(std::string file, int frame) {
  const std::string number = std::to_string(frame < 0 ? -int64_t(frame) : int64_t(frame)),
                    sign = frame < 0 ? "-" : "";
  for (size_t begin = file.find('#'); begin != std::string::npos; begin = file.find('#', begin)) {
    const size_t marks = std::min(file.find_first_not_of('#', begin), file.size()) - begin;
    std::string digits = number;
    while (digits.size() + sign.size() < marks) digits.insert(digits.begin(), '0');
    file.replace(begin, marks, sign + digits);
  }
  return file;
}

bool isDeepQuantize(const std::vector<float>& quantize) { return std::max(quantize[1], quantize[3]) > 255; }

int largestCode(const Output& output, const ChannelLayout& layout) {
  constexpr int kByte = 255, kShort = 65535;
  const std::string extension = image::extensionOf(output.file);
  const bool isTiff = extension == "tif" || extension == "tiff";
  if (output.driver == "openexr" || extension == "exr" || extension == "hdr") return 0;
  if (!isTiff && extension != "png") return driverOfExtension(extension).empty() ? 0 : kByte;
  // both can be told how many bits, and a TIFF to hold floats, which it does by itself where it holds data
  const std::vector<float> quantize = output.params.getFloats("quantize");
  const std::string format = isTiff ? output.params.getString("format", "") : "";
  if (format == "uint8") return kByte;
  if (format == "uint16") return kShort;
  if (format == "float32" || format == "float") return 0;
  if (quantize.size() == 4)
    return quantize[1] <= 0 ? (isTiff ? 0 : kShort) : isDeepQuantize(quantize) ? kShort : kByte;
  if (quantize.size() == 1 && quantize[0] >= 0)
    return quantize[0] == 1 ? kByte : isTiff && quantize[0] == 2 ? 0 : kShort;
  const bool hasData = std::any_of(output.channels.begin(), output.channels.end(),
                                   [&](const OutputChannel& c) { return layout[c.channel].isData; });
  return isTiff && hasData ? 0 : kByte;
}

void redirectPrimary(DisplayPlan& plan, const std::string& file, Diagnostics& diagnostics) {
  if (plan.unwritten) plan.outputs.insert(plan.outputs.begin(), *std::exchange(plan.unwritten, {}));
  auto primary = std::find_if(plan.outputs.begin(), plan.outputs.end(), [](const Output& o) { return o.isBeauty; });
  if (primary == plan.outputs.end()) return;
  directTo(*primary, file, diagnostics);
  checkFiles(plan, diagnostics);
}

void keepBeside(DisplayPlan& plan, const std::string& file, Diagnostics& diagnostics) {
  const std::filesystem::path beside = std::filesystem::path(file).parent_path();
  for (Output& o : plan.outputs) {
    std::error_code failed;
    const std::filesystem::path there = o.file, folder = there.parent_path();
    if (o.file == file || folder.empty() || std::filesystem::is_directory(folder, failed)) continue;
    o.file = (beside / there.filename()).string();
    diagnostics.warning("DISPLAY-FOLDER", o.pos, "the folder of picture \"" + there.string() + "\" does not exist",
                        "it is written as \"" + o.file + "\"");
  }
  checkFiles(plan, diagnostics);
}

bool isShadowPass(const scene::Scene& scene) {
  return !scene.displays.empty() && std::all_of(scene.displays.begin(), scene.displays.end(), [](const auto& d) {
    return d.driver == "shadow" || d.driver == "deepshad" || d.driver == "zfile";
  });
}

DisplayPlan planDisplays(const scene::Scene& scene, const PlanOptions& options, const DriverLookup& lookup,
                         Diagnostics& diagnostics) {
  DisplayPlan plan;
  plan.pixelAspect = scene.pixelAspect > 0 ? scene.pixelAspect : 1.0f;
  plan.displayFilters = scene.displayFilters;
  size_t primary;
  std::vector<scene::Display> displays = wantedDisplays(scene, primary);
  if (displays.empty() && options.output.empty()) {
    displays.push_back({"untitled.exr", "openexr", "rgba", {}, scene.pos});
    diagnostics.info("DISPLAY-NONE", scene.pos,
                     "the scene has no Display; the picture is written to \"untitled.exr\"");
  } else if (primary == displays.size() && !options.output.empty()) {
    displays.insert(displays.begin(), beautyFor(scene));
    primary = 0;
  }
  for (size_t i = 0; i < displays.size(); ++i) {
    const scene::Display& d = displays[i];
    Output out;
    out.file = fillFrame(d.file, scene.frame);
    out.params = d.params;
    out.pos = d.pos;
    out.isBeauty = hasBeauty(scene, d);
    bool isWritten = true;
    if (i == primary && !options.output.empty())
      directTo(out, fillFrame(options.output, scene.frame), diagnostics);
    else
      isWritten = chooseDriver(d, lookup, diagnostics, out);
    addChannels(scene, d, options, plan, out, diagnostics);
    if (!isWritten && options.isPart && i == primary) plan.unwritten = out;
    if (!isWritten || options.noOutputs || out.channels.empty()) continue;
    plan.outputs.push_back(std::move(out));
  }
  if (options.isPart && primary == displays.size()) {
    const scene::Display beauty = beautyFor(scene);
    Output out;
    out.isBeauty = true;
    out.pos = beauty.pos;
    addChannels(scene, beauty, options, plan, out, diagnostics);
    plan.unwritten = std::move(out);
  }
  if (plan.layout.size() == 0) {
    Channel ci = colorChannel("Ci");
    ci.splats = options.splats;
    plan.layout.add(ci);
    plan.layout.add(floatChannel("a"));
  }
  checkFiles(plan, diagnostics);
  return plan;
}

}  // namespace kinora::film
