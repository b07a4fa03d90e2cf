#include "image/colors.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>

namespace kinora::image {

namespace ocio = OCIO_NAMESPACE;

namespace {

// Roles and names under which configurations keep the space of ordinary 8-bit textures.
constexpr const char* kTextureSpaces[] = {
    "texture_paint", "matte_paint", "srgb_texture", "sRGB - Texture", "Utility - sRGB - Texture",
    "sRGB",          "srgb",        "color_picking"};

std::string firstLine(std::string text) {
  if (const size_t line = text.find_first_of("\r\n"); line != std::string::npos) text.resize(line);
  return text;
}

}  // namespace

struct Colors::Impl {
  ocio::ConstConfigRcPtr config;
  std::string problem, workingSpace = "linear Rec.709 (sRGB primaries)";
  std::string bytesSpace;  // of textures of 8 bits; "": the configuration has none
  mutable std::mutex mutex;
  mutable std::map<std::string, ocio::ConstCPUProcessorRcPtr> processors;  // null: cannot be made

  template <class Make>
  ocio::ConstCPUProcessorRcPtr processor(const std::string& key, Make make) const {
    const std::lock_guard lock(mutex);
    if (const auto it = processors.find(key); it != processors.end()) return it->second;
    ocio::ConstCPUProcessorRcPtr made;
    try {
      made = make()->getDefaultCPUProcessor();
    } catch (const ocio::Exception&) {  // the caller falls back
    }
    return processors[key] = made;
  }
};

const Colors& Colors::ofEnvironment() {
  static const Colors colors([] {
    const char* file = std::getenv("OCIO");
    return std::string(file ? file : "");
  }());
  return colors;
}

Colors::Colors(const std::string& configuration) : impl_(std::make_unique<Impl>()) {
  if (configuration.empty()) return;
  try {
    ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);  // messages are the renderer's to give
    const ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(configuration.c_str());
    config->validate();
    const ocio::ConstColorSpaceRcPtr linear = config->getColorSpace(ocio::ROLE_SCENE_LINEAR);
    if (!linear) throw ocio::Exception("it has no role scene_linear");
    impl_->workingSpace = linear->getName();
    for (const char* name : kTextureSpaces)
      if (const auto space = config->getColorSpace(name)) {
        impl_->bytesSpace = space->getName();
        break;
      }
    impl_->config = config;
  } catch (const std::exception& e) {
    impl_->problem = "the OpenColorIO configuration '" + configuration + "' cannot be used: " + firstLine(e.what());
  }
}

Colors::~Colors() = default;

bool Colors::isManaged() const { return impl_->config != nullptr; }
const std::string& Colors::problem() const { return impl_->problem; }
const std::string& Colors::workingSpace() const { return impl_->workingSpace; }

std::string Colors::spaceOf(const std::string& file, bool isBytes) const {
  if (!isManaged()) return {};
  try {
    size_t rule = 0;
    const char* space = impl_->config->getColorSpaceFromFilepath(file.c_str(), rule);
    const size_t last = impl_->config->getFileRules()->getNumEntries() - 1;  // the default rule
    if (rule != last && space && *space) return space;
  } catch (const ocio::Exception&) {  // a rule that cannot be evaluated says nothing
  }
  return isBytes ? impl_->bytesSpace : impl_->workingSpace;
}

bool Colors::toWorking(const std::string& file, bool isBytes, float* pixels, size_t n, int channels,
                       int alphaChannel) const {
  const std::string space = spaceOf(file, isBytes);
  if (space.empty()) return false;
  const auto cpu = impl_->processor(
      "from " + space, [&] { return impl_->config->getProcessor(space.c_str(), impl_->workingSpace.c_str()); });
  if (!cpu) return false;
  if (cpu->isNoOp()) return true;
  // one or two channels: grey, which has the same three values
  const bool isGrey = channels < 3;
  for (size_t i = 0; i < n; ++i) {
    float* p = pixels + i * size_t(channels);
    float rgb[3] = {p[0], isGrey ? p[0] : p[1], isGrey ? p[0] : p[2]};
    if (alphaChannel == 0) continue;
    cpu->applyRGB(rgb);
    if (isGrey)
      p[0] = (rgb[0] + rgb[1] + rgb[2]) / 3;
    else
      std::copy_n(rgb, 3, p);
  }
  return true;
}

std::vector<std::string> Colors::views() const {
  std::vector<std::string> list;
  if (!isManaged()) return list;
  for (int d = 0; d < impl_->config->getNumDisplays(); ++d) {
    const char* display = impl_->config->getDisplay(d);
    for (int v = 0; v < impl_->config->getNumViews(display); ++v)
      list.push_back(std::string(display) + "/" + impl_->config->getView(display, v));
  }
  return list;
}

std::string Colors::findView(const std::string& view) const {
  if (!isManaged()) return {};
  const std::string display = impl_->config->getDefaultDisplay();
  const std::string wanted =
      view == "default" ? display + "/" + impl_->config->getDefaultView(display.c_str()) : view;
  const std::vector<std::string> all = views();
  for (const std::string& candidate : {wanted, display + "/" + wanted})
    if (std::find(all.begin(), all.end(), candidate) != all.end()) return candidate;
  for (const std::string& v : all)
    if (v.ends_with("/" + wanted)) return v;
  return {};
}

bool Colors::toView(const std::string& fullName, float* rgb, size_t n, size_t stride) const {
  const size_t slash = fullName.find('/');
  if (!isManaged() || slash == std::string::npos) return false;
  const std::string display = fullName.substr(0, slash), view = fullName.substr(slash + 1);
  const auto cpu = impl_->processor("view " + fullName, [&] {
    return impl_->config->getProcessor(impl_->workingSpace.c_str(), display.c_str(), view.c_str(),
                                       ocio::TRANSFORM_DIR_FORWARD);
  });
  if (!cpu) return false;
  for (size_t i = 0; i < n; ++i) cpu->applyRGB(rgb + i * stride);
  return true;
}

}  // namespace kinora::image
