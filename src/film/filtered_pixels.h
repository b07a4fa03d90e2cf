// Finished pixels that display filters changed, channel by channel, for the whole window of a film. Made by render/
// (which knows the filters) each time pictures are written; read by display_output.h in place of the film's own.
#pragma once
#include <algorithm>
#include <cstddef>
#include <map>
#include <vector>

#include "image/image.h"

namespace kinora::film {

struct FilteredPixels {
  struct Channel {
    int width = 0;
    std::vector<float> values;  // row by row, all floats of a pixel together
  };
  image::Window window;
  std::map<int, Channel> channels;  // by index in the film's layout

  // False when no filter touched the channel.
  bool find(int channel, int x, int y, float* out) const {
    const auto it = channels.find(channel);
    if (it == channels.end() || !window.contains(x, y)) return false;
    const size_t pixel = size_t(y - window.y0) * size_t(window.width()) + size_t(x - window.x0);
    std::copy_n(it->second.values.data() + pixel * size_t(it->second.width), it->second.width, out);
    return true;
  }
};

}  // namespace kinora::film
