#include "film/display_output.h"

#include <kinora/display.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <set>

#include "base/text.h"
#include "film/display_files.h"
#include "image/atomic_file.h"
#include "image/colors.h"
#include "image/picture_library.h"
#include "image/read_write.h"
#include "image/straight_alpha.h"

namespace kinora::film {
namespace {

// Parameters that any display may carry; those that Kinora has no use for are accepted in silence.
bool isCommon(const std::string& name) {
  static const std::vector<std::string> names = commonDisplayParameters();
  return std::find(names.begin(), names.end(), name) != names.end() || name.starts_with("exrheader_") ||
         name.starts_with("dspy");
}

const char* aliasOf(const std::string& declared) {
  if (declared == "compression") return "exrcompression";
  if (declared == "compressionlevel") return "exrcompressionlevel";
  if (declared == "exrpixeltype") return "type";
  return nullptr;
}

// The values of a driver's parameters: the scene's where it gives them in the right type, else the declared defaults.
class DriverValues {
 public:
  DriverValues(const Descriptor& driver, const Output& output, Diagnostics& diagnostics) {
    numbers_.resize(driver.paramCount);
    strings_.resize(driver.paramCount);
    pointers_.resize(driver.paramCount);
    values_.resize(driver.paramCount);
    for (uint32_t i = 0; i < driver.paramCount; ++i) {
      const Param& p = driver.params[i];
      const scene::Parameter* given = output.params.find(p.name);
      if (!given && aliasOf(p.name)) given = output.params.find(aliasOf(p.name));
      if (given && !take(p, *given, i)) {
        diagnostics.warning("DISPLAY-PARAMETER", given->pos,
                            "parameter \"" + given->name + "\" of display \"" + output.file + "\" has the wrong type",
                            "its default is used");
        given = nullptr;
      }
      if (given && !isChoice(p, *given)) {
        diagnostics.warning("DISPLAY-PARAMETER", given->pos,
                            "parameter \"" + given->name + "\" of display \"" + output.file + "\" is \"" +
                                given->strings[0] + "\", which is none of " + p.choices,
                            std::string("\"") + p.text + "\" is used");
        given = nullptr;
      }
      if (!given) {
        numbers_[i] = {p.value[0], p.value[1], p.value[2]};
        strings_[i] = {p.text};
      }
      finish(p, given != nullptr, i);
    }
    for (const scene::Parameter& given : output.params) {
      const bool isKnown = std::any_of(driver.params, driver.params + driver.paramCount, [&](const Param& p) {
        return given.name == p.name || (aliasOf(p.name) && given.name == aliasOf(p.name));
      });
      if (!isKnown && !isCommon(given.name))
        diagnostics.warning(
            "DISPLAY-PARAMETER", given.pos,
            "display driver \"" + std::string(driver.name) + "\" has no parameter \"" + given.name + "\"", "ignored");
    }
  }
  const ParamValue* values() const { return values_.data(); }
  uint32_t count() const { return uint32_t(values_.size()); }

 private:
  // Words for which a driver has a list: one of it, in any case.
  static bool isChoice(const Param& p, const scene::Parameter& given) {
    if (p.type != Type::String || !p.choices || !*p.choices) return true;
    const std::string list = "|" + lowerCase(p.choices) + "|", word = lowerCase(given.strings[0]);
    return word.empty() || list.find("|" + word + "|") != std::string::npos;
  }
  bool take(const Param& p, const scene::Parameter& given, uint32_t i) {
    if (p.type == Type::String) {
      if (given.strings.empty()) return false;
      strings_[i] = given.strings;
      return true;
    }
    std::vector<float> numbers = given.floats;
    if (numbers.empty()) numbers.assign(given.ints.begin(), given.ints.end());
    if (numbers.empty()) return false;
    // RIB's "int[4] quantize" [zero one min max] for a switch: codes up to 255 mean 8 bits, one 0 floats
    if (given.name == "quantize" && numbers.size() == 4)
      numbers = {numbers[1] <= 0 ? 2.0f : isDeepQuantize(numbers) ? 0.0f : 1.0f};
    numbers_[i] = std::move(numbers);
    return true;
  }
  void finish(const Param& p, bool isGiven, uint32_t i) {
    ParamValue& v = values_[i];
    v.given = isGiven;
    if (p.type == Type::String) {
      for (const std::string& s : strings_[i]) pointers_[i].push_back(s.c_str());
      v.strings = pointers_[i].data();
      v.count = uint32_t(pointers_[i].size());
    } else {
      v.floats = numbers_[i].data();
      v.count = uint32_t(numbers_[i].size());
    }
  }
  std::vector<std::vector<float>> numbers_;
  std::vector<std::vector<std::string>> strings_;
  std::vector<std::vector<const char*>> pointers_;
  std::vector<ParamValue> values_;
};

// The view that a display asks for, by its whole name; "" when the configuration has none of that name.
std::string viewOf(const Output& output) {
  return image::Colors::ofEnvironment().findView(output.params.getString("view", ""));
}

// A parameter as metadata: one value or a matrix as such, several as a text with a blank between them.
image::MetaValue headerValueOf(const scene::Parameter& p) {
  if (p.strings.size() == 1) return p.strings[0];
  if (p.ints.size() == 1) return p.ints[0];
  if (p.floats.size() == 1) return p.floats[0];
  if (image::Matrix44 m; p.floats.size() == m.size()) {
    std::copy(p.floats.begin(), p.floats.end(), m.begin());
    return m;
  }
  std::string all;
  const auto add = [&](const std::string& value) { all += (all.empty() ? "" : " ") + value; };
  for (const std::string& s : p.strings) add(s);
  for (const int i : p.ints) add(std::to_string(i));
  for (const float f : p.floats) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", double(f));
    add(text);
  }
  return all;
}

std::string rangesText(const std::vector<SampleRange>& ranges) {
  std::string s;
  for (const SampleRange& r : ranges)
    s += (s.empty() ? "" : ",") + std::to_string(r.begin) + ":" + std::to_string(r.end);
  return s;
}

}  // namespace

std::vector<std::string> commonDisplayParameters() {
  return {"quantize",
          "dither",
          "exposure",
          "filter",
          "filterwidth",
          "merge",
          "camera",
          "origin",
          "mode",
          "remap",
          "resolution",
          "asrgba",
          "asrgbacolorchannel",
          "asrgbaalphachannel",
          "dspyParams",
          "connection",
          "resolutionunit",
          "format",
          "compression",
          "exrcompression",
          "view"};
}

std::map<std::string, image::MetaValue> metadataOf(const FrameMetadata& frame) {
  std::map<std::string, image::MetaValue> m = frame.more;
  // OpenEXR's names and RenderMan's: readers know one or the other
  m["worldToCamera"] = m["worldtocamera"] = frame.worldToCamera;
  if (frame.worldToNdc) m["worldToNDC"] = m["worldtoNDC"] = *frame.worldToNdc;
  m["frame"] = frame.frame;
  m["seed"] = std::to_string(frame.seed);  // 64 bits: no numeric attribute holds them
  m["sampleRange"] = rangesText(frame.samples);
  m["samplesPerPixel"] = float(frame.samplesPerPixel);
  m["renderSeconds"] = float(frame.renderSeconds);
  m["Software"] = "Kinora " + frame.kinoraVersion;
  m["kinoraVersion"] = frame.kinoraVersion;
  if (!frame.sceneHash.empty()) m["sceneHash"] = frame.sceneHash;  // an early picture may be without
  m["pixelFilter"] = frame.pixelFilter;
  m["colorSpace"] = image::Colors::ofEnvironment().workingSpace();
  m["complete"] = int(frame.isComplete);
  return m;
}

image::Image pictureOf(const Film& film, const Output& output,
                       const std::map<std::string, image::MetaValue>& metadata, const FilteredPixels* filtered,
                       bool isStraight) {
  std::vector<image::ChannelInfo> infos;
  for (const OutputChannel& c : output.channels)
    for (const std::string& name : c.names)
      infos.push_back({name, film.layout()[c.channel].isData ? image::StoredType::Float : image::StoredType::Half});
  image::Image picture(film.window(), std::move(infos));
  picture.display = {0, 0, film.width(), film.height()};
  picture.metadata = metadata;
  const float codes = float(largestCode(output, film.layout()));
  size_t alpha = 0, at = 0;
  bool hasAlpha = false;
  for (const OutputChannel& c : output.channels) {
    if (!hasAlpha && !c.isColor && c.names.size() == 1 && (c.names[0] == "A" || c.names[0] == "a")) {
      hasAlpha = true;
      alpha = at;
    }
    at += c.names.size();
  }
  for (int y = film.window().y0; y < film.window().y1; ++y)
    for (int x = film.window().x0; x < film.window().x1; ++x) {
      float* out = picture.at(x, y);
      for (const OutputChannel& c : output.channels) {
        if (!filtered || !filtered->find(c.channel, x, y, out)) film.resolvePixel(c.channel, x, y, out);
        out += film.layout()[c.channel].width;
      }
    }
  if (hasAlpha && isStraight) {
    std::vector<size_t> colors;
    size_t k = 0;
    for (const OutputChannel& c : output.channels)
      for (size_t i = 0; i < c.names.size(); ++i, ++k)
        if (c.isColor) colors.push_back(k);
    image::makeStraight(picture, colors, alpha);
  }
  for (int y = film.window().y0; y < film.window().y1; ++y)
    for (int x = film.window().x0; x < film.window().x1; ++x) {
      float *const first = picture.at(x, y), *out = first;
      for (const OutputChannel& c : output.channels) {
        const int width = film.layout()[c.channel].width;
        if (c.values != DisplayValues())
          for (int k = 0; k < width; ++k)
            out[k] = displayed(out[k], c.values, c.isColor, codes, c.isColor, x, y, int(out - first) + k);
        out += width;
      }
    }
  return picture;
}

DisplayOutput::DisplayOutput(DisplayPlan plan, DriverLookup lookup, Diagnostics& diagnostics)
    : plan_(std::move(plan)), lookup_(std::move(lookup)), diagnostics_(diagnostics) {}

bool DisplayOutput::fail(const Output& output, const std::string& why) {
  if (isSnapshot_) {
    diagnostics_.warning("DISPLAY-SNAPSHOT", output.pos,
                         "the picture so far cannot be written to \"" + output.file + "\": " + why,
                         "the render goes on and tries again", "free the space before the render ends");
    return false;
  }
  diagnostics_.error("DISPLAY-WRITE", output.pos, "picture \"" + output.file + "\" cannot be written: " + why,
                     "what was there before is kept", "check the folder, its permissions and the free space");
  return false;
}

bool DisplayOutput::probe() {
  bool ok = true;
  for (const Output& o : plan_.outputs) {
    if (const image::Status s = image::AtomicFile(o.file).probe(); !s.ok()) ok = fail(o, s.what);
    if (needsPictureLibrary(o) && !image::isPictureLibraryThere())
      ok = fail(o, "the library that writes such files, libkinora_pictures.so, is not installed");
  }
  return ok;
}

const Descriptor* DisplayOutput::driverOf(const Output& output) const {
  const Descriptor* driver = output.driver != kImageWriter && lookup_ ? lookup_(output.driver) : nullptr;
  const bool isUsable = driver && driver->kind == Kind::Display && driver->create && driver->destroy &&
                        driver->tableCount == 1 && driver->tables[0].functions;
  return isUsable ? driver : nullptr;
}

bool DisplayOutput::needsPictureLibrary(const Output& output) const {
  const Descriptor* driver = driverOf(output);
  const auto* traits = driver ? static_cast<const DisplayTraits*>(driver->traits) : nullptr;
  return !driver || (traits && traits->pictureFiles);
}

bool DisplayOutput::write(const Film& film, const FrameMetadata& frame) {
  written_.clear();
  if (!(film.layout() == plan_.layout)) {
    // render/ may sum channels of its own beside those of the plan
    for (int c = 0; c < plan_.layout.size(); ++c)
      if (c >= film.layout().size() || !(film.layout()[c] == plan_.layout[c])) {
        diagnostics_.error("DISPLAY-INTERNAL", {},
                           "the film lacks channel \"" + plan_.layout[c].name + "\" of the plan",
                           "nothing is written");
        return false;
      }
  }
  const auto metadata = metadataOf(frame);
  screenWindow_ = frame.screenWindow;
  FilteredPixels filtered;
  if (stage_) filtered = stage_(film);
  bool ok = true;
  for (const Output& o : plan_.outputs) {
    bool isWritten = false;
    try {
      isWritten = writeOne(o, film, filtered, metadata);
    } catch (const std::exception& e) {  // memory for a picture's floats
      fail(o, e.what());
    }
    if (isWritten) written_.push_back(o.file);
    ok &= isWritten;
  }
  return ok;
}

void DisplayOutput::snapshot(const Film& film, const FrameMetadata& frame) {
  isSnapshot_ = true;
  write(film, frame);
  isSnapshot_ = false;
}

bool DisplayOutput::writeOne(const Output& output, const Film& film, const FilteredPixels& filtered,
                             const std::map<std::string, image::MetaValue>& metadata) {
  const Descriptor* const driver = driverOf(output);
  const auto* traits = driver ? static_cast<const DisplayTraits*>(driver->traits) : nullptr;
  const bool isStraight =
      driver ? traits && traits->straightAlpha : image::hasStraightAlpha(image::extensionOf(output.file));
  image::Image picture = pictureOf(film, output, metadata, &filtered, isStraight);
  for (const scene::Parameter& p : output.params)
    if (p.name.starts_with("exrheader_") && p.name.size() > 10 && p.size() > 0)
      picture.metadata[p.name.substr(10)] = headerValueOf(p);
  if (driver) return writeByPlugin(output, *driver, std::move(picture));
  return writeByImage(output, std::move(picture));
}

// What the numbers of a picture mean, for its metadata.
std::string DisplayOutput::colorSpaceOf(const Output& output, bool isView) const {
  const image::Colors& colors = image::Colors::ofEnvironment();
  if (largestCode(output, plan_.layout) == 0) return isView ? viewOf(output) : colors.workingSpace();
  if (isView) return viewOf(output);
  const auto colour = std::find_if(output.channels.begin(), output.channels.end(), [](auto& c) { return c.isColor; });
  std::string curve = "sRGB";
  if (colour != output.channels.end() && colour->values.gamma != 1) {
    char text[32];
    std::snprintf(text, sizeof text, "gamma %g", double(colour->values.gamma));
    curve = text;
  }
  return colors.isManaged() ? curve + ", " + colors.workingSpace() : curve;
}

// A driver that has a parameter "view" may be given colours as a view of $OCIO shows them: they are codes then, no
// longer light. True when the picture was changed.
bool DisplayOutput::applyView(const Output& output, const Descriptor& driver, image::Image& picture) {
  const std::string view = output.params.getString("view", "");
  const bool isOffered = std::any_of(driver.params, driver.params + driver.paramCount,
                                     [](const Param& p) { return std::string_view(p.name) == "view"; });
  if (view.empty() || !isOffered) return false;
  const image::Colors& colors = image::Colors::ofEnvironment();
  const std::string name = viewOf(output);
  bool isDone = !name.empty();
  size_t first = 0;
  for (const OutputChannel& c : output.channels) {
    if (isDone && c.isColor && c.names.size() == 3)
      isDone =
          colors.toView(name, picture.pixels.data() + first, size_t(picture.data.pixels()), picture.channels.size());
    first += c.names.size();
  }
  if (isDone) return true;
  std::string known;
  for (const std::string& v : colors.views()) known += (known.empty() ? "" : ", ") + v;
  diagnostics_.warning("DISPLAY-VIEW", output.pos,
                       "picture \"" + output.file + "\" asks for view \"" + view + "\", which is not known",
                       "it is sRGB-encoded",
                       known.empty() ? "views come from the configuration that $OCIO names" : "there are: " + known);
  return false;
}

bool DisplayOutput::writeByPlugin(const Output& output, const Descriptor& driver, image::Image picture) {
  image::AtomicFile file(output.file);
  if (const image::Status s = file.probe(); !s.ok()) return fail(output, s.what);
  const bool isView = applyView(output, driver, picture);
  picture.metadata["colorSpace"] = colorSpaceOf(output, isView);

  std::vector<DisplayChannelInfo> channels;
  std::vector<const float*> pointers;
  size_t k = 0;
  for (const OutputChannel& c : output.channels)
    for (size_t i = 0; i < c.names.size(); ++i, ++k) {
      const bool isHalf = picture.channels[k].type == image::StoredType::Half;
      channels.push_back({c.names[i].c_str(), isHalf ? DisplayPixelType::Half : DisplayPixelType::Float,
                          !c.isColor ? 0u
                          : isView   ? 2u
                                     : 1u});
      pointers.push_back(picture.pixels.data() + k);
    }
  std::vector<DisplayMetadata> metadata;
  for (const auto& [key, value] : picture.metadata) {
    DisplayMetadata m{key.c_str(), DisplayMetadataType::Int, 0, 0, "", nullptr};
    if (const int* i = std::get_if<int>(&value)) m.integer = *i;
    if (const float* f = std::get_if<float>(&value)) m.type = DisplayMetadataType::Float, m.number = *f;
    if (const auto* s = std::get_if<std::string>(&value)) m.type = DisplayMetadataType::String, m.text = s->c_str();
    if (const auto* x = std::get_if<image::Matrix44>(&value))
      m.type = DisplayMetadataType::Matrix, m.matrix = x->data();
    metadata.push_back(m);
  }
  const image::Window& w = picture.data;
  const DisplayInfo info{output.file.c_str(),
                         file.path().c_str(),
                         {uint32_t(picture.display.width()), uint32_t(picture.display.height())},
                         {w.x0, w.y0, w.x1, w.y1},
                         plan_.pixelAspect,
                         channels.data(),
                         uint32_t(channels.size()),
                         metadata.data(),
                         uint32_t(metadata.size()),
                         {screenWindow_[0], screenWindow_[1], screenWindow_[2]},
                         &displayPictureFiles()};
  const DriverValues values(driver, output, diagnostics_);
  // every snapshot makes a driver anew, and what it says of the file is said once
  output_ = &output;
  const Host host{this,
                  [](void* self, const char* code, const char* what, const char* done) {
                    auto& m = *static_cast<DisplayOutput*>(self);
                    if (m.said_.insert(std::string(code) + what).second)
                      m.diagnostics_.warning(code, m.output_->pos, what, done);
                  },
                  [](void*, const char*, int) -> const HostImage* { return nullptr; }};
  const CreateInfo create{&host, output.file.c_str(), values.values(), values.count(), nullptr, &info};
  ErrorText error{};
  void* display = driver.create(&create, &error);
  error.text[sizeof error.text - 1] = 0;
  if (!display) return fail(output, error.text[0] ? error.text : "the driver refused it");
  const auto* functions = static_cast<const DisplayFunctions*>(driver.tables[0].functions);
  const DisplayPixels pixels{pointers.data(), picture.channels.size(), picture.channels.size() * size_t(w.width())};
  const bool isWritten = functions->write(display, &pixels, &error) != 0;
  bool ok = isWritten && functions->close(display, &error) != 0;
  if (!isWritten) functions->abort(display);
  driver.destroy(display);
  error.text[sizeof error.text - 1] = 0;
  if (!ok) return fail(output, error.text[0] ? error.text : "the driver gave up");
  const image::Status s = file.commit();
  return s.ok() || fail(output, s.what);
}

bool DisplayOutput::writeByImage(const Output& output, image::Image picture) {
  const std::string extension = image::extensionOf(output.file);
  picture.metadata["colorSpace"] = colorSpaceOf(output, false);
  const bool isTiff = extension == "tif" || extension == "tiff";
  if (extension != "exr" && extension != "hdr") {
    // pictures to look at: 8 bits unless the display says otherwise
    image::StoredType type = image::StoredType::UInt8;
    const std::string format = output.params.getString("format", "");
    const std::vector<float> quantize = output.params.getFloats("quantize");
    const float one = quantize.size() == 4 ? quantize[1] : 255;
    if (format == "uint16" || (quantize.size() == 4 && isDeepQuantize(quantize))) type = image::StoredType::UInt16;
    if (isTiff && (format == "float32" || (quantize.size() == 4 && one == 0))) type = image::StoredType::Float;
    for (image::ChannelInfo& c : picture.channels) c.type = type;
    if (type != image::StoredType::Float && picture.channels.size() > 4) {
      // integer formats hold a colour and alpha; layers belong into EXR
      image::Image first(picture.data, {picture.channels.begin(), picture.channels.begin() + 4});
      first.display = picture.display;
      first.metadata = picture.metadata;
      for (size_t i = 0; i < size_t(picture.data.pixels()); ++i)
        std::copy_n(&picture.pixels[i * picture.channels.size()], 4, &first.pixels[i * 4]);
      picture = std::move(first);
    }
  }
  image::WriteOptions options;
  options.isStraight = true;  // pictureOf() has seen to it
  const image::Status s = image::write(output.file, picture, options);
  return s.ok() || fail(output, s.what);
}

}  // namespace kinora::film
