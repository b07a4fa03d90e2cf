// Blurred copies of a picture that light shines through (PxrCookieLightFilter): averages over rectangles, wider from copy
// to copy in even steps, and a blend of two of them for what lies between. What surrounds the picture, as its tileMode
// says, is blurred into it. Plain; blurred_picture_kernel.h looks it up.
#pragma once
#include "plugins/lightfilter/parts/picture.h"

namespace kinora::filterParts {

struct BlurredPicture {
  static constexpr int kMost = 8;  // copies
  struct Copy {
    LightMap map;
    float perU = 1, perV = 1, fromU = 0, fromV = 0;  // place in the map: u perU + fromU
  };
  Copy copy[kMost];
  int count = 0;  // 0: there is no blur
  BlurredPicture() = default;
  BlurredPicture(const BlurredPicture&) = delete;
  BlurredPicture& operator=(const BlurredPicture&) = delete;

  // blurU, blurV: width and height of the widest rectangle, in those of the picture.
  void make(const Picture& p, double blurU, double blurV, int copies) {
    if (!p.map.valid() || !(blurU > 0 || blurV > 0)) return;
    count = copies;
    for (int k = 0; k < copies; ++k) {
      const double part = double(k + 1) / copies;
      fill(p, std::clamp(blurU, 0.0, 4.0) * part, std::clamp(blurV, 0.0, 4.0) * part, copy[k]);
    }
  }

 private:
  // One axis of a copy: texels of it that are `step` of the picture's wide, from `margin` of these before its edge on.
  struct Axis {
    int64_t texels, margin, step, count;
    double half;  // of the average, in texels
    Axis(int64_t n, double blur) : texels(n), half(blur * double(n) / 2) {
      step = std::max<int64_t>(1, int64_t(half / 4));
      margin = int64_t(std::ceil(half)) + step;
      count = (n + 2 * margin + step - 1) / step;
    }
    float per() const { return float(double(texels) / double(count * step)); }
    float from() const { return float(double(margin) / double(count * step)); }
    // Averages of the values `at` gives for texels, of this axis outside of the picture too.
    template <class At, class Put>
    void average(const At& at, const Put& put) const {
      const int64_t first = -margin - int64_t(std::ceil(half)) - 1,
                    last = count * step + int64_t(std::ceil(half)) + 1;
      std::vector<double> sum(size_t(last - first) + 1, 0.0);
      for (int64_t i = first; i < last; ++i) sum[size_t(i - first) + 1] = sum[size_t(i - first)] + at(i);
      // the integral up to x, linear within texels
      const auto upTo = [&](double x) {
        const double below = std::floor(x);
        const size_t i = size_t(int64_t(below) - first);
        return sum[i] + (x - below) * (sum[i + 1] - sum[i]);
      };
      const double h = std::max(half, 0.5 * double(step));
      for (int64_t k = 0; k < count; ++k) {
        const double middle = (double(k) + 0.5) * double(step) - double(margin);
        put(k, float((upTo(middle + h) - upTo(middle - h)) / (2 * h)));
      }
    }
  };
  static void fill(const Picture& p, double blurU, double blurV, Copy& out) {
    const int64_t border = p.tileMode == 2 ? 1 : 0, width = p.map.width, height = p.map.height - 2 * border;
    const Axis across(width, blurU), down(height, blurV);
    const auto within = [&](int64_t i, int64_t n) {  // -1: what surrounds the picture
      if (i >= 0 && i < n) return i;
      return p.tileMode == 0 ? int64_t(-1) : p.tileMode == 1 ? std::clamp<int64_t>(i, 0, n - 1) : ((i % n) + n) % n;
    };
    out.map.own.resize(size_t(across.count * down.count) * 3);
    std::vector<float> rows(size_t(across.count * height));
    for (int64_t c = 0; c < 3; ++c) {
      for (int64_t y = 0; y < height; ++y)
        across.average(
            [&](int64_t x) {
              const int64_t at = within(x, width);
              return at < 0 ? double(p.fill[c]) : double(p.map.texels[((y + border) * width + at) * 3 + c]);
            },
            [&](int64_t k, float v) { rows[size_t(y * across.count + k)] = v; });
      for (int64_t x = 0; x < across.count; ++x)
        down.average(
            [&](int64_t y) {
              const int64_t at = within(y, height);
              return at < 0 ? double(p.fill[c]) : double(rows[size_t(at * across.count + x)]);
            },
            [&](int64_t k, float v) { out.map.own[size_t((k * across.count + x) * 3 + c)] = v; });
    }
    out.map.texels = out.map.own.data();
    out.map.width = int32_t(across.count);
    out.map.height = int32_t(down.count);
    out.map.stride = 3;
    out.map.green = 1;
    out.map.blue = 2;
    out.perU = across.per();
    out.perV = down.per();
    out.fromU = across.from();
    out.fromV = down.from();
  }
};

}  // namespace kinora::filterParts
