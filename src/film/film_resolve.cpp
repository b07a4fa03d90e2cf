// A film's integers become the values of pixels.
#include <algorithm>
#include <cmath>

#include "film/film.h"
#include "film/sample_order.h"

namespace kinora::film {

// Means by a filter. Divided by the sum of its weights they would be lost where lobes of both signs nearly cancel, as
// those of few samples do. So each lobe is a mean of its own, which no sign disturbs, and the two are put together as
// the whole filter has them: 1 + c of the positive, -c of the negative (post-stratification; Cochran, "Sampling
// Techniques", 5A.9). A constant stays one with any samples, and in the limit the filter is what it is. A lobe that
// no sample has met is taken to see what the other sees.
void Film::resolveFiltered(int channel, const int64_t* p, double count, double weight, double* out) const {
  const Channel& ch = layout_[channel];
  const FilterSlots& own = filterSlots_[size_t(channel)];
  const int64_t* sums = p + firstSlot(channel);
  if (own.negative < 0) {
    const bool isPlain = own.plain >= 0 && weight == 0;
    // weights of the frame's filter are 1; what a caller makes negative without a word is kept from dividing by
    // nothing
    const bool isSum = own.plain >= 0 ? !isPlain : std::fabs(weight) >= 0.5 * count;
    const double divisor = isSum ? weight : count;
    const double scale = divisor != 0 ? ch.step() / divisor : 0;
    for (int k = 0; k < ch.width; ++k) out[k] = double(isPlain ? p[own.plain + k] : sums[k]) * scale;
    return;
  }
  const double negative = std::ldexp(double(p[own.negativeWeight]), kWeightStepLog2), positive = weight + negative;
  const double share = layout_.negative(layout_.filterOf(channel));
  double ofPositive = 0, ofNegative = 0;
  if (positive > 0) ofPositive = (negative > 0 ? 1 + share : 1) * ch.step() / positive;
  if (negative > 0) ofNegative = (positive > 0 ? -share : 1) * ch.step() / negative;
  for (int k = 0; k < ch.width; ++k) {
    // sums of the negative weights turned positive: the signed sum holds them with the other sign
    const int64_t ofLobe = p[own.negative + k];
    out[k] = double(int64_t(uint64_t(sums[k]) + uint64_t(ofLobe))) * ofPositive + double(ofLobe) * ofNegative;
    if (own.plain >= 0 && positive <= 0 && negative <= 0 && count > 0)
      out[k] = double(p[own.plain + k]) * (ch.step() / count);
  }
}

// Variance of such a mean, or of one by weights that differ: of each lobe the spread of its values, as its weights
// have them, over the number of samples of one weight that are worth as much (Kish, "Survey Sampling", 11.7). A lobe
// with fewer than two is taken to spread as the other does.
double Film::varianceOfMean(int channel, const int64_t* p, double weight, int k) const {
  const Channel& ch = layout_[channel];
  const FilterSlots& own = filterSlots_[size_t(channel)];
  const double share = layout_.negative(layout_.filterOf(channel));
  const auto weights = [&](int slot) { return slot < 0 ? 0 : std::ldexp(double(p[slot]), kWeightStepLog2); };
  const auto sum = [&](int first) { return first < 0 ? 0 : double(p[first + k]) * ch.step(); };
  const auto moment = [&](int first) {
    return first < 0 ? 0 : std::ldexp(double(p[first + ch.width + k]), squareStepLog2(ch));
  };
  const int all = firstSlot(channel);
  struct Lobe {
    double share, weights, squares, sum, moment, count = 0, spread = 0;
  } lobes[2];
  lobes[1] = {share, weights(own.negativeWeight), weights(own.negativeSquares), sum(own.negative),
              moment(own.negative)};
  lobes[0] = {1 + share, weight + lobes[1].weights, weights(own.weightSquares) - lobes[1].squares,
              sum(all) + lobes[1].sum, moment(all) + lobes[1].moment};
  for (Lobe& l : lobes) {
    if (!(l.weights > 0) || !(l.squares > 0)) continue;
    const double mean = l.sum / l.weights;
    l.count = l.weights * l.weights / l.squares;
    if (l.count >= 1.5) l.spread = std::max(0.0, l.moment / l.weights - mean * mean) * l.count / (l.count - 1);
  }
  double variance = 0;
  for (int i = 0; i < 2; ++i) {
    const Lobe &l = lobes[i], &other = lobes[1 - i];
    if (!(l.count > 0)) continue;
    const double part = other.count > 0 ? l.share : 1;
    variance += part * part * (l.count >= 1.5 ? l.spread : other.spread) / l.count;
  }
  return variance;
}

void Film::resolvePixel(int channel, int x, int y, float* out) const {
  const Channel& ch = layout_[channel];
  const FilterSlots& own = filterSlots_[size_t(channel)];
  const int64_t* p = pixel(x, y);
  const int slot = firstSlot(channel);
  const auto ofHalf = [&](int all, int even) {
    return ch.half == Half::Both ? p[all] : ch.half == Half::Even ? p[even] : p[all] - p[even];
  };
  const double count = double(ofHalf(kCount, kCountEven));
  const double weight =
      std::ldexp(double(own.weight >= 0 ? p[own.weight] : ofHalf(kWeight, kWeightEven)), kWeightStepLog2);
  if (ch.statistic != Statistic::Value) {
    // of y = value x weight, whose mean is the pixel: (sum y^2 - (sum y)^2 / n) / (n - 1)
    for (int k = 0; k < ch.width; ++k) {
      if (own.weightSquares >= 0) {
        const double v = varianceOfMean(channel, p, weight, k);
        out[k] = float(ch.statistic == Statistic::MeanVariance ? v : v * count);
        continue;
      }
      const double sum = double(p[slot + k]) * ch.step();
      const double squares = double(p[slot + ch.width + k]) * std::ldexp(1.0, squareStepLog2(ch));
      double v = count > 1 ? std::max(0.0, (squares - sum * sum / count) / (count - 1)) : 0.0;
      if (ch.statistic == Statistic::MeanVariance && count > 0) v /= count;
      out[k] = float(v);
    }
    return;
  }
  double mean[4] = {};
  switch (ch.reducer) {
    case Reducer::Sum:
      resolveFiltered(channel, p, count, weight, mean);
      break;
    case Reducer::Average:
    case Reducer::Total: {
      const double scale = ch.reducer == Reducer::Total ? ch.step() : count != 0 ? ch.step() / count : 0;
      for (int k = 0; k < ch.width; ++k) mean[k] = double(p[slot + k]) * scale;
      break;
    }
    case Reducer::Min:
      for (int k = 0; k < ch.width; ++k) out[k] = p[slot + k] ? std::min(decodeMin(p[slot + k]), kNoDepth) : 0;
      return;
    case Reducer::Max:
      for (int k = 0; k < ch.width; ++k) out[k] = p[slot + k] ? std::min(decodeMax(p[slot + k]), kNoDepth) : 0;
      return;
    case Reducer::ZMin:
    case Reducer::ZMax:
      for (int k = 0; k < ch.width; ++k) out[k] = std::min(std::bit_cast<float>(uint32_t(p[slot + k])), kNoDepth);
      return;
  }
  const int splatSlot = firstSplatSlot(channel);
  const int64_t passes = splatPasses();
  for (int k = 0; k < ch.width; ++k) {
    double v = mean[k];
    if (splatSlot >= 0 && passes > 0) v += double(p[splatSlot + k]) * (ch.step() / double(passes));
    out[k] = ch.isRemapped() ? expand(float(v), ch.remap) : float(v);
  }
}

image::Image Film::resolve(int channel) const {
  const int width = layout_[channel].width;
  std::vector<image::ChannelInfo> infos;
  for (int k = 0; k < width; ++k)
    infos.push_back(
        {std::to_string(k), layout_[channel].isData ? image::StoredType::Float : image::StoredType::Half});
  image::Image img(window_, std::move(infos));
  img.display = {0, 0, width_, height_};
  for (int y = window_.y0; y < window_.y1; ++y)
    for (int x = window_.x0; x < window_.x1; ++x) resolvePixel(channel, x, y, img.at(x, y));
  return img;
}

}  // namespace kinora::film
