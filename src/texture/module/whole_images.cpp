// Images that plug-ins ask for as a whole (HostImage): every pixel in memory, as floats.
#include <OpenImageIO/imageio.h>

#include <algorithm>

#include "image/colors.h"
#include "image/module/pixels.h"
#include "texture/module/open_textures.h"

namespace kinora::texture {

const HostImage* OpenTextures::image(const std::string& file, int linearize, const TextureRequest& request) {
  std::lock_guard lock(imageMutex);
  const auto key = std::make_pair(file, linearize);
  if (const auto it = images.find(key); it != images.end()) {
    if (contents) contents->again(kContentKind, file);
    return it->second ? &it->second->image : nullptr;
  }
  note(file, {});
  std::unique_ptr<HeldImage> held;
  try {
    held = load(file, linearize, request);
  } catch (const MemoryExceeded&) {  // no fault of the file
    throw;
  } catch (const std::exception& e) {
    diagnostics.warning("ASSET-TEXTURE-READ", request.pos, named(file, request) + " cannot be used: " + e.what(),
                        "no image is used");
  }
  const HostImage* result = held ? &held->image : nullptr;
  images.emplace(key, std::move(held));
  return result;
}

std::unique_ptr<HeldImage> OpenTextures::load(const std::string& file, int linearize, const TextureRequest& request) {
  size_t exact = 0;
  const std::vector<std::string> list = texture::candidates(file, searchPath, exact);
  std::string code = "ASSET-TEXTURE-MISSING", what = named(file, request) + " is not there";
  for (size_t i = 0; i < list.size(); ++i) {
    FileFacts facts;
    std::string why = texture::examine(list[i], facts);
    auto held = std::make_unique<HeldImage>();
    if (why.empty()) {
      OIIO::ImageSpec config;
      config.attribute("oiio:UnassociatedAlpha", 1);
      auto input = OIIO::ImageInput::open(list[i], &config);
      const int channels = std::min(facts.channels, 4);
      if (input) {
        held->memory.add(uint64_t(facts.width) * uint64_t(facts.height) * uint64_t(channels) * sizeof(float));
        held->pixels.resize(size_t(facts.width) * size_t(facts.height) * size_t(channels));
        if (!image::readPixels(*input, channels, held->pixels.data())) why = firstLine(input->geterror());
      } else {
        why = firstLine(OIIO::geterror());
      }
      if (why.empty()) {
        const int alpha = facts.alphaChannel < channels ? facts.alphaChannel : -1;
        const size_t pixels = size_t(facts.width) * size_t(facts.height);
        if (linearize != 0 &&
            !image::Colors::ofEnvironment().toWorking(list[i], facts.bytes, held->pixels.data(), pixels, channels,
                                                      alpha) &&
            (linearize == 1 || facts.srgb))
          texture::decodeSrgb(held->pixels.data(), pixels, channels, alpha, facts.bytes);
        note(file, {list[i]});
        held->image = {held->pixels.data(), uint32_t(facts.width), uint32_t(facts.height), uint32_t(channels)};
        imageBytes.fetch_add(held->pixels.size() * sizeof(float), std::memory_order_relaxed);
        if (i > 0 || exact == 0) diagnostics.warning(code, request.pos, what, "'" + list[i] + "' is used instead");
        return held;
      }
    }
    if (i == 0) {
      code = "ASSET-TEXTURE-READ";
      what = named(file, request) + " cannot be used: '" + list[i] + "': " + why;
    }
  }
  diagnostics.warning(code, request.pos, what, "no image is used", "check the texture search path");
  return nullptr;
}

}  // namespace kinora::texture
