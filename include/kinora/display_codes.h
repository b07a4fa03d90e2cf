// What drivers of plain pictures (PNG, JPEG, TIFF) share: which channels a format holds, and pixels as 8- or 16-bit
// codes. Used by display drivers. It knows no file format and writes nothing.
#pragma once
#include <kinora/display.h>
#include <kinora/math/srgb.h>

#include <cstring>
#include <string>
#include <vector>

namespace kinora {

// Alpha by its name, with or without a layer: "A", "a", "diffuse.A".
inline bool isAlphaChannel(const DisplayChannelInfo& c) {
  const char* dot = std::strrchr(c.name, '.');
  const char* last = dot ? dot + 1 : c.name;
  return !c.isColor && (std::strcmp(last, "A") == 0 || std::strcmp(last, "a") == 0);
}

// The channels of a format for looking at: the first colour, with alpha when there is one and the format has it; a
// picture without a colour gives its first channel as grey. Channels of a colour come together, three of them.
inline std::vector<uint32_t> channelsToLookAt(const DisplayInfo& d, bool withAlpha) {
  std::vector<uint32_t> list;
  for (uint32_t c = 0; c + 2 < d.channelCount && list.empty(); ++c)
    if (d.channels[c].isColor && d.channels[c + 1].isColor && d.channels[c + 2].isColor) list = {c, c + 1, c + 2};
  if (list.empty() && d.channelCount > 0) list = {0};
  for (uint32_t c = 0; c < d.channelCount && withAlpha; ++c)
    if (isAlphaChannel(d.channels[c]) && c != list[0]) {
      list.push_back(c);
      break;
    }
  return list;
}

// Says once which channels a file does not have. Alpha is not missed in formats that have none.
inline void warnOfChannels(const CreateInfo& info, const DisplayInfo& d, const std::vector<uint32_t>& held) {
  std::string missed;
  int count = 0;
  for (uint32_t c = 0; c < d.channelCount; ++c) {
    bool isHeld = isAlphaChannel(d.channels[c]) && held.size() != 1;
    for (const uint32_t h : held) isHeld |= h == c;
    if (isHeld) continue;
    constexpr int kNamed = 4;
    if (count < kNamed) missed += (count ? ", " : "") + std::string(d.channels[c].name);
    if (count++ == kNamed) missed += " ...";
  }
  if (count == 0 || !info.host || !info.host->warn) return;
  const std::string what = "picture \"" + std::string(d.file) + "\" cannot hold " + std::to_string(count) +
                           (count == 1 ? " channel: " : " channels: ") + missed;
  info.host->warn(info.host->self, "DISPLAY-CHANNELS", what.c_str(), "left out; an .exr holds all of them");
}

// Pixels of the listed channels, one after the other: scene-linear colours (isLight) sRGB-encoded, all else as it is.
template <typename Int>
std::vector<Int> pictureCodes(const DisplayPixels& p, const std::vector<uint32_t>& channels,
                              const std::vector<bool>& isLight, size_t width, size_t height) {
  constexpr uint32_t kMost = Int(-1);
  const SrgbEncoder encoder(int(kMost) + 1);
  std::vector<Int> codes;
  codes.reserve(width * height * channels.size());
  for (size_t y = 0; y < height; ++y)
    for (size_t x = 0; x < width; ++x)
      for (size_t k = 0; k < channels.size(); ++k) {
        const float v = p.channels[channels[k]][y * p.rowStride + x * p.pixelStride];
        codes.push_back(Int(isLight[k] ? encoder.encode(v) : quantizeLinear(v, kMost)));
      }
  return codes;
}

}  // namespace kinora
