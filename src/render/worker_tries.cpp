// Groups that are tried in worlds with parts that have not been read: what they leave behind is kept, or taken back.
#include <algorithm>
#include <array>
#include <bit>

#include "render/services.h"
#include "trace/unread_notes.h"

namespace kinora::render {

void Worker::beginTry() {
  try_.isOpen = state_.world().world->unread() != nullptr;
  trace::UnreadNotes::ofThread() = {};
  if (!try_.isOpen) return;
  try_.notes = trace::UnreadBounds::notesOfThread();
  try_.met.assign((state_.world().world->unread()->size() + 63) / 64, 0);
  trace::UnreadNotes::ofThread() = {try_.met.data(), try_.met.size()};
  try_.counters = state_.counters;
  try_.lightRays = lightRays;
  try_.splats.clear();
  if (store) store->mark(index, try_.records);
  if (learned) try_.lessons = learned->mark(index);
}

void Worker::beginLook() {
  beginTry();
  if (try_.isOpen) return;
  try_.isOpen = true;
  try_.counters = state_.counters;
  try_.lightRays = lightRays;
  try_.splats.clear();
}

void Worker::endLook() {
  try_.isOpen = false;
  trace::UnreadNotes::ofThread() = {};
  try_.splats.clear();
  state_.counters = try_.counters;
  lightRays = try_.lightRays;
}

bool Worker::keepTry() {
  if (!try_.isOpen) return true;
  try_.isOpen = false;
  trace::UnreadNotes::ofThread() = {};
  if (trace::UnreadBounds::notesOfThread() != try_.notes) {
    const auto spent = std::to_array(state_.counters.nanoseconds);
    state_.counters = try_.counters;
    std::copy(spent.begin(), spent.end(), state_.counters.nanoseconds);
    lightRays = try_.lightRays;
    if (store) store->cut(index, try_.records);
    if (learned) learned->cut(index, try_.lessons);
    return false;
  }
  for (const Try::Splat& s : try_.splats) {
    const float* const values[3] = {&s.value[0], &s.value[1], &s.value[2]};
    const uint32_t first = 0;
    film_.splat({1, s.channel, &s.x, &s.y, &first, values});
  }
  return true;
}

std::vector<uint32_t> Worker::metUnread() const {
  std::vector<uint32_t> out;
  for (uint32_t w = 0; w < try_.met.size(); ++w)
    for (uint64_t bits = try_.met[w]; bits; bits &= bits - 1)
      out.push_back(64 * w + uint32_t(std::countr_zero(bits)));
  return out;
}

}  // namespace kinora::render
