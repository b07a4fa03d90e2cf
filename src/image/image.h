// A picture in memory: named float channels over a data window, with metadata. Made by image/read_write.h and by
// film/, read by the display drivers' host side, by compare.h and by the tools. It converts nothing and knows no file
// format: the type of a channel is only what a file should store.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kinora::image {

// Pixels x0 <= x < x1, y0 <= y < y1; y runs down.
struct Window {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 > x0 ? x1 - x0 : 0; }
  int height() const { return y1 > y0 ? y1 - y0 : 0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  bool contains(const Window& w) const { return w.x0 >= x0 && w.x1 <= x1 && w.y0 >= y0 && w.y1 <= y1; }
  uint64_t pixels() const { return uint64_t(width()) * uint64_t(height()); }
  bool operator==(const Window&) const = default;
};

enum class StoredType : uint8_t { UInt8, UInt16, Half, Float };

struct ChannelInfo {
  std::string name;  // as in the file: "R", "diffuse.G", "Z"
  StoredType type = StoredType::Half;
};

using Matrix44 = std::array<float, 16>;  // row-major, row vectors
using MetaValue = std::variant<int, float, std::string, Matrix44>;

struct Image {
  Window data;     // where pixels are
  Window display;  // the full picture; crop renders have a smaller data window
  std::vector<ChannelInfo> channels;
  std::vector<float> pixels;  // row by row, all channels of a pixel together
  std::map<std::string, MetaValue> metadata;

  Image() = default;
  Image(Window dataWindow, std::vector<ChannelInfo> chans)
      : data(dataWindow),
        display(dataWindow),
        channels(std::move(chans)),
        pixels(size_t(dataWindow.pixels()) * channels.size(), 0.0f) {}
  int width() const { return data.width(); }
  int height() const { return data.height(); }
  int channelCount() const { return int(channels.size()); }
  int findChannel(std::string_view name) const;  // -1: none
  // x, y in the data window's coordinates
  float* at(int x, int y) { return pixels.data() + offset(x, y); }
  const float* at(int x, int y) const { return pixels.data() + offset(x, y); }

 private:
  size_t offset(int x, int y) const {
    return (size_t(y - data.y0) * size_t(width()) + size_t(x - data.x0)) * channels.size();
  }
};

inline int Image::findChannel(std::string_view name) const {
  for (size_t i = 0; i < channels.size(); ++i)
    if (channels[i].name == name) return int(i);
  return -1;
}

// Channels that are no colour in pictures to look at: alpha and depth, with or without a layer ("diffuse.A").
inline bool isAlphaName(const std::string& channel) {
  const size_t dot = channel.rfind('.');
  const std::string last = dot == std::string::npos ? channel : channel.substr(dot + 1);
  return last == "A" || last == "a" || last == "alpha" || last == "Z" || last == "z";
}

}  // namespace kinora::image
