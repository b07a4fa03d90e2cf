// The media around each ray of a list: what rays meet, pass and cross.
#include <algorithm>

#include "shade/beer_lambert.h"
#include "shade/context_host.h"

namespace kinora::shade {

bool GroupState::insideHigherPriority(const RayList& list, uint32_t entry) const {
  const uint32_t stack = ListHost::of(list).left.media[entry];
  if (!stack) return false;
  const uint32_t instance = list.hits.instance[entry], geometry = list.hits.geometry[entry];
  const uint32_t body = world_.world->bodyOf(instance, geometry);
  const int own = world_.placementOf(instance, geometry).priority;
  for (uint32_t k = stack; k; k = media_[k].outer)
    if (media_[k].object != body && media_[k].priority > own) return true;
  return false;
}

// Boundaries that the listed rays pass, since another medium displaces theirs, change the media around them.
void GroupState::crossDisplaced(RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries) {
  uint32_t* const media = ListHost::of(list).left.media;
  Context* const* contexts;
  const uint32_t count = shade(list, kTraitEyePath | kTraitPresenceQuery, depth, n, entries, &contexts);
  for (uint32_t c = 0; c < count; ++c) {
    const Context* x = contexts[c];
    uint32_t* points = x->alloc<uint32_t>(x->padded);
    uint32_t* stacks = x->alloc<uint32_t>(x->padded);
    for (uint32_t i = 0; i < x->count; ++i) {
      points[i] = i;
      stacks[i] = media[x->path[i]];
    }
    updateMedia(x, x->count, points, nullptr, stacks);
    for (uint32_t i = 0; i < x->count; ++i) media[x->path[i]] = stacks[i];
  }
}

// Beer and Lambert along the segments just traced, in the medium that fills space there.
void GroupState::absorb(const RayList& list, uint32_t n, const uint32_t* entries, float* const transmittance[3]) {
  const uint32_t* stacks = ListHost::of(list).left.media;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    if (!stacks[s]) continue;
    const float* a = media_[media_.filling(stacks[s])].absorption;
    const float t = list.hits.t[s];
    // a ray that escapes from inside a medium crosses it without end
    for (int c = 0; c < 3; ++c) transmittance[c][s] *= beerLambert(a[c], t);
  }
}

// Index of refraction around the object that each point lies on: of what fills space but for the medium that this
// surface bounds.
void GroupState::findOuterIor(const Context* c, const uint32_t* stacks, float* ior) const {
  for (uint32_t i = 0; i < c->padded; ++i) {
    ior[i] = 1.f;
    if (!stacks[i]) continue;
    const uint32_t object = world_.world->bodyOf(c->place.instance[i], c->place.geometry[i]);
    // Seen from inside, the surface ends the medium that its object or its material began. Seen from outside it is
    // about to begin one; a ray that is in its object's medium all the same has missed the way out.
    uint32_t own = media_.leftBy(stacks[i], object, world_.materialOf(c->place.instance[i], c->place.geometry[i]));
    if (own && c->entering[i] && media_[own].object != object) own = MediaPool::kEmpty;
    if (const uint32_t around = media_.filling(stacks[i], own)) ior[i] = media_[around].ior;
  }
}

// Stacks beyond the surface at the listed points, in place: stacks[i] is that of points[i].
void GroupState::updateMedia(const Context* c, uint32_t n, const uint32_t* points, const uint32_t* through,
                             uint32_t* stacks) {
  const ContextHost& h = ContextHost::of(c);
  if (!h.program || !h.program->encloses || !c->bxdf->interior) return;
  if (through && std::none_of(through, through + n, [](uint32_t x) { return x != 0; })) return;
  float* x[4];
  for (float*& y : x) y = c->alloc<float>(c->padded);
  const InteriorArgs a{x[0], {x[1], x[2], x[3]}};
  c->bxdf->interior(c, &a);
  for (uint32_t i = 0; i < n; ++i) {
    if (through && !through[i]) continue;
    const uint32_t p = points[i], instance = c->place.instance[p], geometry = c->place.geometry[p];
    const uint32_t material = world_.materialOf(instance, geometry);
    const uint32_t object = world_.world->bodyOf(instance, geometry);
    if (c->entering[p]) {
      const PlacementInfo& place = world_.placementOf(instance, geometry);
      stacks[i] = media_.push(stacks[i], {object, material, place.priority, x[0][p], {x[1][p], x[2][p], x[3][p]}, 0});
    } else {
      stacks[i] = media_.without(stacks[i], media_.leftBy(stacks[i], object, material));
    }
  }
}

}  // namespace kinora::shade
