#include "scene/digests.h"

#include <type_traits>

#include "scene/digester.h"

namespace kinora::scene {

namespace {

const Surroundings& noSurroundings() {
  static const ContentsByName kNoFiles;
  static const Surroundings kNone{kNoFiles, Places(Scene())};
  return kNone;
}

template <class T>
Digest digestAlone(const T& thing) {
  return Digester(noSurroundings()).of(thing);
}

template <class T>
Digest withoutAttributes(const T& thing) {
  Digester digester(noSurroundings());
  Hasher h;
  forEachField(thing, [&]<class F>(const F& field, const typename F::Member& member) {
    if constexpr (!std::is_same_v<typename F::Member, AttributesPtr>) h.digest(digester.of(field, member));
  });
  return h.result();
}

template <class T>
constexpr bool kStandsInWorld =
    std::is_same_v<T, std::vector<Camera>> || std::is_same_v<T, std::vector<PrimitivePtr>> ||
    std::is_same_v<T, std::vector<Prototype>> || std::is_same_v<T, InstanceList> ||
    std::is_same_v<T, std::vector<Light>> || std::is_same_v<T, std::map<std::string, Transform>>;

}  // namespace

Digest digestOf(const Camera& camera) { return digestAlone(camera); }
Digest digestOf(const Network& network) { return digestAlone(network); }
Digest digestOf(const NodePtr& node) { return digestAlone(node); }
Digest digestOf(const ParameterList& list) { return digestAlone(list); }
Digest digestOf(const Transform& transform) { return digestAlone(transform); }
Digest digestOf(const std::map<std::string, Transform>& spaces) { return digestAlone(spaces); }
Digest ownDigestOf(const Primitive& primitive) { return withoutAttributes(primitive); }
Digest ownDigestOf(const Light& light) { return withoutAttributes(light); }

Digest frameDigestOf(const Scene& scene) {
  Digester digester(noSurroundings(), Digester::Of::Everything);
  Hasher h;
  forEachField(scene, [&]<class F>(const F& field, const typename F::Member& member) {
    // the number of the next thing says nothing
    if constexpr (!kStandsInWorld<typename F::Member>) {
      const void* at = &member;
      if (at != &scene.nextId) h.digest(digester.of(field, member));
    }
  });
  return h.result();
}

Digest NetworkDigests::of(const NetworkPtr& network) {
  if (!network) return {};
  const auto [it, isNew] = known_.try_emplace(network.get());
  if (isNew) it->second = {network, digestOf(*network)};
  it->second.isAsked = true;
  return it->second.digest;
}

void NetworkDigests::forgetOthers() {
  std::erase_if(known_, [](const auto& entry) { return !entry.second.isAsked; });
  for (auto& [key, known] : known_) known.isAsked = false;
}

}  // namespace kinora::scene
