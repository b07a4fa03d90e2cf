// Digests of what a description says, by the lists of scene/fields.h. The walk itself: used inside scene/ by
// identity.cpp and digests.cpp alone, since its templates take long to compile.
#pragma once
#include <bit>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/digest.h"
#include "scene/fields.h"
#include "scene/identity.h"

namespace kinora::scene {

template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsVector<LeanVector<T>> : std::true_type {};
template <class T>
struct IsVector<Keys<T>> : std::true_type {};
template <>
struct IsVector<InstanceList> : std::true_type {};
template <class T>
struct IsArray : std::false_type {};
template <class T, size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};
template <class T>
struct IsShared : std::false_type {};
template <class T>
struct IsShared<std::shared_ptr<T>> : std::true_type {};
template <class T>
struct IsMap : std::false_type {};
template <class T>
struct IsMap<std::map<std::string, T>> : std::true_type {};
template <class T>
constexpr bool kIsNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;
// Values without padding and without owners: their bytes are what they say.
template <class T>
constexpr bool kIsBytes = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_same_v<T, Matrix>;

// Where in the scene the things are that others name by their id. Only light sources are named so: objects list those
// that shine on them, and an area light is an object as well.
class Places {
 public:
  explicit Places(const Scene& scene) {
    if (scene.classicLights.empty()) return;
    for (size_t i = 0; i < scene.classicLights.size(); ++i)
      places_.try_emplace(scene.classicLights[i].id, uint64_t(i) << 1 | 1);
    for (size_t i = 0; i < scene.primitives.size(); ++i)
      places_.try_emplace(scene.primitives[i]->id, uint64_t(i) << 1);
  }
  uint64_t of(uint32_t id) const {
    const auto it = places_.find(id);
    return it == places_.end() ? ~uint64_t(id) : it->second;
  }

 private:
  std::unordered_map<uint32_t, uint64_t> places_;
};

// What digests depend on beside the thing itself.
struct Surroundings {
  const ContentsByName& files;
  Places places;
};

// Digests of things. It remembers those of what things share, so that each is worked out once; one for each thread.
class Digester {
 public:
  // What counts: what decides pixels, or what is noted for people as well.
  enum class Of : uint8_t { Pixels, Everything };
  explicit Digester(const Surroundings& s, Of of = Of::Pixels) : s_(s), of_(of) {}

  template <class T>
  Digest of(const T& value) {
    Hasher h;
    add(h, value);
    return h.result();
  }
  template <class F>
  Digest of(const F& field, const typename F::Member& value) {
    Hasher h;
    add(h, field, value);
    return h.result();
  }

 private:
  template <class F>
  void add(Hasher& h, const F& field, const typename F::Member& value) {
    if constexpr (F::kCounts == Counts::ByPlace)
      addPlaces(h, value);
    else if constexpr (std::is_same_v<typename F::Member, ParameterList>)
      addParameters(h, value, of_ == Of::Pixels ? field.isCounted : nullptr);
    else if (F::kCounts == Counts::Always || of_ == Of::Everything)
      add(h, value);
  }

  void addPlaces(Hasher& h, const std::shared_ptr<const std::vector<uint32_t>>& ids) {
    h.word(ids ? ids->size() + 1 : 0);
    if (ids)
      for (const uint32_t id : *ids) h.word(s_.places.of(id));
  }

  // What parameters say may be names of files.
  void addArgument(Hasher& h, const std::string& text) {
    const auto file = s_.files.find(text);
    h.word(file != s_.files.end());
    file != s_.files.end() ? h.digest(file->second) : h.text(text);
  }

  void addParameters(Hasher& h, const ParameterList& list, bool (*isCounted)(const Parameter&)) {
    uint64_t count = 0;
    for (const Parameter& p : list)
      if (!isCounted || isCounted(p)) add(h, p), ++count;
    h.word(count);
  }

  // Shared by many owners: once.
  template <class T>
  void addShared(Hasher& h, const std::shared_ptr<T>& pointer) {
    using Plain = std::remove_const_t<T>;
    h.word(pointer != nullptr);
    if (!pointer) return;
    if constexpr (std::is_same_v<Plain, Attributes>) {
      // mostly those of the object before
      if (pointer.get() != lastAttributes_) {
        digestOfLast_ = of(*pointer);
        lastAttributes_ = pointer.get();
      }
      h.digest(digestOfLast_);
    } else if constexpr (std::is_same_v<Plain, Network> || IsMap<Plain>::value) {
      auto it = known_.find(pointer.get());
      if (it == known_.end()) it = known_.emplace(pointer.get(), of(*pointer)).first;
      h.digest(it->second);
    } else {
      add(h, *pointer);
    }
  }

  template <class T>
  void add(Hasher& h, const T& value) {
    if constexpr (std::is_same_v<T, float>) {
      h.word(std::bit_cast<uint32_t>(value));
    } else if constexpr (std::is_same_v<T, double>) {
      h.word(std::bit_cast<uint64_t>(value));
    } else if constexpr (kIsNumber<T>) {
      h.word(uint64_t(value));
    } else if constexpr (std::is_same_v<T, Matrix>) {
      h.bytes(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      h.text(value);
    } else if constexpr (std::is_same_v<T, SourcePos>) {
      h.text(value.file ? *value.file : std::string());
      h.word(value.line);
    } else if constexpr (std::is_same_v<T, ParameterList>) {
      addParameters(h, value, nullptr);
    } else if constexpr (std::is_same_v<T, std::vector<std::string>> || std::is_same_v<T, LeanVector<std::string>>) {
      h.word(value.size());
      for (const std::string& one : value) addArgument(h, one);
    } else if constexpr (IsVector<T>::value || IsArray<T>::value) {
      if constexpr (kIsBytes<typename T::value_type>) {
        h.bytes(value.data(), value.size() * sizeof(typename T::value_type));
      } else {
        h.word(value.size());
        for (const auto& one : value) add(h, one);
      }
    } else if constexpr (IsMap<T>::value) {
      h.word(value.size());
      for (const auto& [name, one] : value) h.text(name), add(h, one);
    } else if constexpr (IsShared<T>::value) {
      addShared(h, value);
    } else if constexpr (detail::IsOptional<T>::value) {
      h.word(value.has_value());
      if (value) add(h, *value);
    } else if constexpr (std::is_same_v<T, Shape>) {
      h.word(value.index());
      std::visit([&](const auto& shape) { add(h, shape); }, value);
    } else if constexpr (std::is_same_v<T, Node>) {
      const bool leavesOut = of_ == Of::Pixels && isHider(value);
      forEachField(value, [&]<class F>(const F& field, const typename F::Member& member) {
        if constexpr (std::is_same_v<typename F::Member, ParameterList>)
          addParameters(h, member, leavesOut ? hiderDecidesPixels : nullptr);
        else
          add(h, field, member);
      });
    } else {
      forEachField(value, [&](const auto& field, const auto& member) { add(h, field, member); });
      // which object the light is as well, and so does not stand in the scene a second time
      if constexpr (std::is_same_v<T, Light>)
        if (value.geometry) h.word(s_.places.of(value.geometry->id));
    }
  }

  const Surroundings& s_;
  const Of of_;
  const void* lastAttributes_ = nullptr;
  Digest digestOfLast_;
  std::unordered_map<const void*, Digest> known_;
};

}  // namespace kinora::scene
