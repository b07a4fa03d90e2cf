#include "film/display_plan.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "base/text.h"
#include "film/display_channels.h"
#include "film/light_paths.h"

namespace kinora::film {
namespace {

std::string extensionOf(const std::string& file) {
  const size_t dot = file.rfind('.');
  return dot == std::string::npos || file.find('/', dot) != std::string::npos ? "" : lowerCase(file.substr(dot + 1));
}

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
  const std::string extension = extensionOf(out.file);
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
  // "file" is RIB's word for "the usual format"
  if (driver != "file" && driver != kImageWriter && !driver.empty())
    diagnostics.warning("DISPLAY-DRIVER", display.pos, "display driver \"" + display.driver + "\" is not known",
                        "\"" + out.file + "\" is written");
  return true;
}

std::vector<std::string> namesIn(const scene::Display& display) {
  static const std::map<std::string, std::vector<std::string>> modes{
      {"rgb", {"Ci"}}, {"rgba", {"Ci", "a"}}, {"rgbaz", {"Ci", "a", "z"}}, {"rgbz", {"Ci", "z"}},       {"a", {"a"}},
      {"z", {"z"}},    {"az", {"a", "z"}},    {"rgbo", {"Ci", "Oi"}},      {"rgboz", {"Ci", "Oi", "z"}}};
  if (const auto it = modes.find(display.mode); it != modes.end()) return it->second;
  std::vector<std::string> list;
  std::string name;
  for (const char c : display.mode + ",") {
    if (c != ',' && !std::isspace(static_cast<unsigned char>(c)))
      name += c;
    else if (!name.empty())
      list.push_back(std::exchange(name, {}));
  }
  if (list.empty()) list = {"Ci", "a"};
  return list;
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
  for (const std::string& name : namesIn(display)) {
    int index = plan.layout.find(name);
    // what is wrong with a channel has been said when it was first asked for
    Diagnostics silent([](const std::string&, Severity) {});
    Diagnostics& messages = index >= 0 ? silent : diagnostics;
    Channel c = describeChannel(scene, name, display, messages);
    c.splats = takesSplats(c, display, options, messages);
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

bool hasBeauty(const scene::Display& d) {
  const std::vector<std::string> names = namesIn(d);
  return std::find(names.begin(), names.end(), "Ci") != names.end();
}

// The displays of the scene, with the primary one overridden by -o. The reader has applied RIB's "+" (add) and its
// absence (replace); a "+" that a scene made otherwise still holds is dropped.
std::vector<scene::Display> wantedDisplays(const scene::Scene& scene, const PlanOptions& options,
                                           Diagnostics& diagnostics) {
  std::vector<scene::Display> list;
  for (scene::Display d : scene.displays) {
    if (d.file.starts_with("+")) d.file = d.file.substr(1);
    if (d.file.empty()) d.file = "untitled";
    list.push_back(std::move(d));
  }
  auto primary = std::find_if(list.begin(), list.end(), hasBeauty);
  if (!options.output.empty()) {
    if (primary == list.end()) primary = list.insert(list.begin(), scene::Display{{}, {}, "rgba", {}, {}});
    const std::string extension = extensionOf(options.output);
    primary->file = options.output;
    primary->driver = driverOfExtension(extension);
    if (primary->driver.empty())
      diagnostics.warning("DISPLAY-EXTENSION", primary->pos,
                          "the extension of \"" + options.output + "\" names no picture format",
                          "\"" + options.output + ".exr\" is written", "use .exr, .png, .tif or .jpg");
  } else if (list.empty()) {
    list.push_back({"untitled.exr", "openexr", "rgba", {}, scene.pos});
    diagnostics.info("DISPLAY-NONE", scene.pos,
                     "the scene has no Display; the picture is written to \"untitled.exr\"");
  }
  return list;
}

}  // namespace

std::string fillFrame(std::string file, int frame) {
  const size_t begin = file.find('#');
  if (begin == std::string::npos) return file;
  const size_t end = std::min(file.find_first_not_of('#', begin), file.size());
  std::string digits = std::to_string(frame < 0 ? -int64_t(frame) : int64_t(frame));
  const std::string sign = frame < 0 ? "-" : "";
  while (digits.size() + sign.size() < end - begin) digits.insert(digits.begin(), '0');
  return file.replace(begin, end - begin, sign + digits);
}

bool storesIntegers(const Output& output, const ChannelLayout& layout) {
  const std::string extension = extensionOf(output.file);
  if (output.driver == "openexr") return false;
  for (const char* e : {"png", "jpg", "jpeg", "tga", "bmp", "ppm"})
    if (extension == e) return true;
  if (extension != "tif" && extension != "tiff") return false;
  // a TIFF can be told to hold floats, and does where it holds data
  const std::vector<float> quantize = output.params.getFloats("quantize");
  const std::string format = output.params.getString("format", "");
  if (quantize.size() == 4 || !format.empty())
    return format != "float32" && !(quantize.size() == 4 && quantize[1] == 0);
  return std::none_of(output.channels.begin(), output.channels.end(),
                      [&](const OutputChannel& c) { return layout[c.channel].isData; });
}

void redirectPrimary(DisplayPlan& plan, const std::string& file, Diagnostics& diagnostics) {
  const auto isPrimary = [&](const Output& o) {
    return std::any_of(o.channels.begin(), o.channels.end(),
                       [&](const OutputChannel& c) { return plan.layout[c.channel].name == "Ci"; });
  };
  if (plan.outputs.empty()) return;
  auto primary = std::find_if(plan.outputs.begin(), plan.outputs.end(), isPrimary);
  if (primary == plan.outputs.end()) primary = plan.outputs.begin();
  primary->file = file;
  primary->driver = driverOfExtension(extensionOf(file));
  if (!primary->driver.empty()) return;
  diagnostics.warning("DISPLAY-EXTENSION", primary->pos, "the extension of \"" + file + "\" names no picture format",
                      "\"" + file + ".exr\" is written", "use .exr, .png, .tif or .jpg");
  primary->file += ".exr";
  primary->driver = "openexr";
}

DisplayPlan planDisplays(const scene::Scene& scene, const PlanOptions& options, const DriverLookup& lookup,
                         Diagnostics& diagnostics) {
  DisplayPlan plan;
  plan.pixelAspect = scene.pixelAspect > 0 ? scene.pixelAspect : 1.0f;
  for (const scene::Display& d : wantedDisplays(scene, options, diagnostics)) {
    Output out;
    out.file = fillFrame(d.file, scene.frame);
    out.params = d.params;
    out.pos = d.pos;
    const bool isWritten = chooseDriver(d, lookup, diagnostics, out);
    addChannels(scene, d, options, plan, out, diagnostics);
    if (!isWritten || options.noOutputs || out.channels.empty()) continue;
    if (out.channels.empty()) continue;
    // a framebuffer beside a file display of one name: one picture is enough
    const auto same =
        std::find_if(plan.outputs.begin(), plan.outputs.end(), [&](auto& o) { return o.file == out.file; });
    if (same != plan.outputs.end()) {
      if (same->channels.size() < out.channels.size()) same->channels = std::move(out.channels);
      continue;
    }
    plan.outputs.push_back(std::move(out));
  }
  if (plan.layout.size() == 0) {
    Channel ci = colorChannel("Ci");
    ci.splats = options.splats;
    plan.layout.add(ci);
    plan.layout.add(floatChannel("a"));
  }
  return plan;
}

}  // namespace kinora::film
