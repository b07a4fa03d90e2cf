#include "image/straight_alpha.h"

#include <algorithm>
#include <cmath>

namespace kinora::image {

namespace {

// Light where nothing covers, carried on smoothly over all pixels: means of ever larger squares, taken from the smallest
// one that knows any (Gortler and others, "The Lumigraph", 1996: pull and push).
class LightBehind {
 public:
  LightBehind(const Image& image, const std::vector<size_t>& colors, size_t alpha) : n_(colors.size()) {
    const size_t pixels = image.pixels.size() / image.channels.size();
    const auto isKnown = [&](const float* p) {
      bool isGood = p[alpha] == 0;
      for (size_t c = 0; c < n_; ++c) isGood = isGood && std::isfinite(p[colors[c]]);
      return isGood;
    };
    // most pictures have none
    for (size_t i = 0; i < pixels && isDark_; ++i) {
      const float* p = image.pixels.data() + i * image.channels.size();
      for (size_t c = 0; c < n_ && isKnown(p); ++c) isDark_ = isDark_ && p[colors[c]] == 0;
    }
    if (isDark_) return;
    Level first(image.width(), image.height(), n_);
    for (size_t i = 0; i < pixels; ++i) {
      const float* p = image.pixels.data() + i * image.channels.size();
      if (!isKnown(p)) continue;
      first.weight[i] = 1;
      for (size_t c = 0; c < n_; ++c) first.value[i * n_ + c] = p[colors[c]];
    }
    levels_.push_back(std::move(first));
    while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(pulled(levels_.back()));
    for (size_t l = levels_.size() - 1; l-- > 0;) push(levels_[l + 1], levels_[l]);
  }
  bool isDark() const { return isDark_; }
  const float* at(size_t pixel) const { return levels_[0].value.data() + pixel * n_; }

 private:
  struct Level {
    int width, height;
    std::vector<float> weight, value;  // value: of weight 0 where nothing is known
    Level(int w, int h, size_t n)
        : width(w), height(h), weight(size_t(w) * size_t(h), 0.f), value(size_t(w) * size_t(h) * n, 0.f) {}
  };
  Level pulled(const Level& fine) const {
    Level coarse((fine.width + 1) / 2, (fine.height + 1) / 2, n_);
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x) {
        const size_t from = size_t(y) * size_t(fine.width) + size_t(x);
        const size_t to = size_t(y / 2) * size_t(coarse.width) + size_t(x / 2);
        coarse.weight[to] += fine.weight[from];
        for (size_t c = 0; c < n_; ++c) coarse.value[to * n_ + c] += fine.weight[from] * fine.value[from * n_ + c];
      }
    for (size_t i = 0; i < coarse.weight.size(); ++i) {
      if (!(coarse.weight[i] > 0)) continue;
      for (size_t c = 0; c < n_; ++c) coarse.value[i * n_ + c] /= coarse.weight[i];
      coarse.weight[i] = 1;
    }
    return coarse;
  }
  // What is not known is between the four squares around.
  void push(const Level& coarse, Level& fine) const {
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x) {
        const size_t to = size_t(y) * size_t(fine.width) + size_t(x);
        if (fine.weight[to] > 0) continue;
        const int x0 = x / 2, y0 = y / 2;
        const int x1 = std::clamp(x0 + (x % 2 ? 1 : -1), 0, coarse.width - 1);
        const int y1 = std::clamp(y0 + (y % 2 ? 1 : -1), 0, coarse.height - 1);
        const auto value = [&](int cx, int cy, size_t c) {
          return coarse.value[(size_t(cy) * size_t(coarse.width) + size_t(cx)) * n_ + c];
        };
        for (size_t c = 0; c < n_; ++c)
          fine.value[to * n_ + c] = 0.75f * (0.75f * value(x0, y0, c) + 0.25f * value(x1, y0, c)) +
                                    0.25f * (0.75f * value(x0, y1, c) + 0.25f * value(x1, y1, c));
      }
  }

  size_t n_;
  std::vector<Level> levels_;
  bool isDark_ = true;
};

}  // namespace

void makeStraight(Image& image, const std::vector<size_t>& colors, size_t alpha) {
  const size_t channels = image.channels.size();
  if (colors.empty() || image.pixels.empty()) return;
  const LightBehind behind(image, colors, alpha);
  for (size_t i = 0; i * channels < image.pixels.size(); ++i) {
    float* p = image.pixels.data() + i * channels;
    const float a = p[alpha];
    if (!(a > 0 && a < 1)) continue;
    for (size_t c = 0; c < colors.size(); ++c) {
      float& x = p[colors[c]];
      // what a negative lobe has made negative stays so
      if (!behind.isDark()) x = std::max(x - (1 - a) * behind.at(i)[c], std::min(x, 0.f));
      x /= a;
    }
  }
}

}  // namespace kinora::image
