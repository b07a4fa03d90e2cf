#include "fuzz/image_input.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz/scratch_folder.h"
#include "image/read_write.h"
#include "texture/texture_system.h"

namespace kinora::fuzz {

namespace {

const std::string& folder() {
  static const ScratchFolder kFolder;
  return kFolder.path;
}

const char* extensionOf(std::string_view b) {
  if (b.starts_with("\x89PNG")) return ".png";
  if (b.starts_with("\xff\xd8")) return ".jpg";
  if (b.starts_with("\x76\x2f\x31\x01")) return ".exr";
  if (b.starts_with("#?RADIANCE")) return ".hdr";
  if (b.starts_with("BM")) return ".bmp";
  if (b.starts_with("II") || b.starts_with("MM")) return ".tif";
  return ".tga";  // has no magic
}

}  // namespace

ImageOutcome loadImageInput(std::string_view bytes) {
  const std::string path = folder() + "/input" + extensionOf(bytes);
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  ImageOutcome out;
  image::ReadOptions options;
  options.maxBytes = 64 << 20;
  image::Image picture;
  out.words = image::readHeader(path, picture, options).what;
  const image::Status status = image::read(path, picture, options);
  out.read = status.ok();
  out.words += status.what;
  if (out.read) {  // what is read is all there
    for (float v : picture.pixels) out.sum += double(v);
  }

  Diagnostics messages([](const std::string&, Severity) {});
  TextureSystem textures(messages);
  textures.setCacheLimit(8 << 20);
  const int32_t handle = textures.handle(path, {});
  constexpr uint32_t kPoints = 16;
  float s[kPoints], t[kPoints], radius[kPoints], rgba[4][kPoints];
  float* const to[4] = {rgba[0], rgba[1], rgba[2], rgba[3]};
  for (uint32_t i = 0; i < kPoints; ++i) {
    s[i] = float(i % 4) * 0.3f - 0.1f;
    t[i] = float(i / 4) * 0.3f;
    radius[i] = std::ldexp(1.f, -int(i));
  }
  textures.lookup(&handle, false, kPoints, s, t, radius, {}, to);
  out.isTexture = handle >= 0 && textures.statistics().missingLookups == 0;
  textures.image(path, -1, {});
  for (const Message& m : messages.messages()) out.words += m.code + m.what;
  // the same words for every run: the folder's name is not one
  for (size_t at; (at = out.words.find(folder())) != std::string::npos;) out.words.erase(at, folder().size());
  unlink(path.c_str());
  return out;
}

std::vector<std::pair<std::string, std::string>> smallImages() {
  image::Image picture({0, 0, 40, 24}, {{"R"}, {"G"}, {"B"}, {"A"}});
  for (size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = float((i * 37) % 101) / 100.f;
  std::vector<std::pair<std::string, std::string>> out;
  const auto keep = [&](const std::string& name) {
    std::ifstream in(folder() + "/" + name, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!bytes.empty()) out.emplace_back(name, std::move(bytes));
    unlink((folder() + "/" + name).c_str());
  };
  for (const char* name : {"a.png", "a.jpg", "a.tif", "a.hdr", "a.tga", "a.bmp"}) {
    (void)image::write(folder() + "/" + name, picture);
    keep(name);
  }
  for (int c = 0; c <= int(image::Compression::Dwab); ++c)
    for (bool isTiled : {false, true}) {
      image::WriteOptions options;
      options.compression = image::Compression(c);
      options.isTiled = isTiled;
      const std::string name = "a" + std::to_string(c) + (isTiled ? "t" : "s") + ".exr";
      (void)image::write(folder() + "/" + name, picture, options);
      keep(name);
    }
  for (const char* name : {"mip.tx", "mip.exr"})
    for (auto type : {OIIO::TypeUInt8, OIIO::TypeHalf}) {
      OIIO::ImageSpec spec(40, 24, 4, type);
      OIIO::ImageBuf buffer(spec);
      OIIO::ImageBufAlgo::checker(buffer, 5, 5, 1, {1.f, 0.2f, 0.f, 1.f}, {0.f, 0.5f, 1.f, 1.f});
      OIIO::ImageSpec config;
      config.tile_width = config.tile_height = 16;
      if (OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, buffer, folder() + "/" + name, config))
        keep(name);
      if (!out.empty() && out.back().first == name) out.back().first = type.c_str() + out.back().first;
    }
  return out;
}

}  // namespace kinora::fuzz
