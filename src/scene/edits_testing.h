// For tests: a scene in which every field of every type has content, and every small edit that can be made to a
// scene, each with its path. Both walk the lists of scene/fields.h, so that a new field is filled and edited without
// a word here; a type of member that is new is a static_assert. Included by tests alone.
#pragma once
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "scene/fields.h"

namespace kinora::scene::test {

namespace detail {
template <class T>
struct Kind {
  static constexpr bool isVector = false, isArray = false, isShared = false, isOptional = false, isMap = false;
};
template <class T>
struct Kind<std::vector<T>> : Kind<void> {
  static constexpr bool isVector = true;
};
template <class T>
struct Kind<LeanVector<T>> : Kind<void> {
  static constexpr bool isVector = true;
};
template <class T>
struct Kind<Keys<T>> : Kind<void> {
  static constexpr bool isVector = true;
};
template <>
struct Kind<InstanceList> : Kind<void> {
  static constexpr bool isVector = true;
};
template <class T, size_t N>
struct Kind<std::array<T, N>> : Kind<void> {
  static constexpr bool isArray = true;
};
template <class T>
struct Kind<std::shared_ptr<T>> : Kind<void> {
  static constexpr bool isShared = true;
};
template <class T>
struct Kind<std::optional<T>> : Kind<void> {
  static constexpr bool isOptional = true;
};
template <class T>
struct Kind<std::map<std::string, T>> : Kind<void> {
  static constexpr bool isMap = true;
};
template <class T>
constexpr bool isNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;
}  // namespace detail

// Content for everything, the same for each seed.
class Filler {
 public:
  explicit Filler(uint32_t seed) : rng_(seed) {}
  template <class T>
  void fill(T& value) {
    using K = detail::Kind<T>;
    if constexpr (std::is_same_v<T, bool>) {
      value = rng_() % 2;
    } else if constexpr (std::is_enum_v<T>) {
      value = T(rng_() % 2);
    } else if constexpr (std::is_same_v<T, uint32_t>) {
      value = T(rng_());  // ids, of which no two are one
    } else if constexpr (std::is_arithmetic_v<T>) {
      value = T(1 + rng_() % 1000);
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = "s" + std::to_string(rng_() % 1000000);
    } else if constexpr (std::is_same_v<T, Matrix>) {
      for (int i = 0; i < 16; ++i) fill(value[i / 4][i % 4]);
    } else if constexpr (std::is_same_v<T, SourcePos>) {
      value = {FileName("filled.rib"), uint32_t(rng_() % 1000)};
    } else if constexpr (std::is_same_v<T, ParameterList>) {
      for (int i = 0; i < 2; ++i) {
        Parameter p;
        fill(p);
        value.set(std::move(p));
      }
    } else if constexpr (std::is_same_v<T, Shape>) {
      fillShape(value, nextShape_++);
    } else if constexpr (std::is_same_v<T, InstanceList>) {
      for (int i = 0; i < 2; ++i) {
        Instance one;
        fill(one);
        value.push_back(std::move(one));
      }
    } else if constexpr (K::isVector) {
      // of each kind of shape there is one, in the first list of primitives
      const bool takesEach = std::is_same_v<T, std::vector<PrimitivePtr>> && nextShape_ == 0;
      // what holds whole worlds once
      const bool isLarge = std::is_same_v<T, std::vector<Prototype>> || std::is_same_v<T, std::vector<Light>>;
      value.resize(takesEach ? std::variant_size_v<Shape> : isLarge ? 1 : 2);
      for (auto& one : value) fill(one);
    } else if constexpr (K::isArray) {
      for (auto& one : value) fill(one);
    } else if constexpr (K::isShared) {
      std::remove_const_t<typename T::element_type> made;
      fill(made);
      value = std::make_shared<decltype(made)>(std::move(made));
    } else if constexpr (K::isOptional) {
      fill(value.emplace());
    } else if constexpr (K::isMap) {
      for (const char* key : {"first", "second"}) fill(value[key]);
    } else {
      static_assert(Described<T>, "a type that stands in no list of scene/fields.h");
      forEachField(value, [&](const auto&, auto& member) { fill(member); });
    }
  }

 private:
  template <size_t I = 0>
  void fillShape(Shape& shape, size_t index) {
    if constexpr (I < std::variant_size_v<Shape>) {
      if (index % std::variant_size_v<Shape> == I)
        fill(shape.emplace<I>());
      else
        fillShape<I + 1>(shape, index);
    }
  }
  std::mt19937 rng_;
  size_t nextShape_ = 0;
};

inline Scene filledScene(uint32_t seed = 1) {
  Scene s;
  Filler(seed).fill(s);
  return s;
}

// A place where a scene can be edited.
struct EditSite {
  std::string path;    // "primitives[2]: attributes: sides"
  bool counts = true;  // by the lists
};

// All small edits of one scene, by number.
class Edits {
 public:
  explicit Edits(const Scene& scene) : scene_(scene) {
    Scene copy = scene;
    edit(copy, "", true);
    isListed_ = true;
  }
  const std::vector<EditSite>& sites() const { return sites_; }
  // The scene with one of them made, or made on another scene of the same shape.
  Scene edited(size_t site) { return edited(scene_, site); }
  Scene edited(Scene scene, size_t site) {
    wanted_ = site;
    next_ = visit_ = 0;
    isDone_ = false;
    edit(scene, "", true);
    return scene;
  }

 private:
  // True where the edit is to be made.
  bool here(const std::string& path, const char* how, bool counts) {
    const size_t at = next_++;
    if (!isListed_) sites_.push_back({path + how, counts});
    isDone_ |= isListed_ && at == wanted_;
    return isListed_ && at == wanted_;
  }
  template <class T>
  static T filled(uint32_t seed) {
    T value{};
    Filler(seed).fill(value);
    return value;
  }
  std::string within(const std::string& path, const std::string& more) const {
    return isListed_ ? path : path + more;
  }

  // Parts that do not hold the edit are passed over: it would copy what they share.
  template <class T>
  void edit(T& value, const std::string& path, bool counts, bool mayBeNull = true) {
    if (isDone_) return;
    const size_t visit = visit_++;
    if (!isListed_) {
      sizes_.push_back({});
      const size_t first = next_;
      apply(value, path, counts, mayBeNull);
      sizes_[visit] = {next_ - first, visit_ - visit};
    } else if (wanted_ < next_ || wanted_ >= next_ + sizes_[visit].sites) {
      next_ += sizes_[visit].sites;
      visit_ = visit + sizes_[visit].visits;
    } else {
      apply(value, path, counts, mayBeNull);
    }
  }

  template <class T>
  void apply(T& value, const std::string& path, bool counts, bool mayBeNull) {
    using K = detail::Kind<T>;
    if constexpr (std::is_same_v<T, bool>) {
      if (here(path, "", counts)) value = !value;
    } else if constexpr (std::is_enum_v<T>) {
      if (here(path, "", counts)) value = T(int(value) ? int(value) - 1 : 1);
    } else if constexpr (std::is_floating_point_v<T>) {
      if (here(path, "", counts)) value += T(0.25);
    } else if constexpr (std::is_arithmetic_v<T>) {
      if (here(path, "", counts)) value = T(value + 1);
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (here(path, "", counts)) value += "x";
      if (!value.empty() && here(path, " cut", counts)) value.pop_back();
    } else if constexpr (std::is_same_v<T, Matrix>) {
      for (const int i : {1, 6, 14, 15}) edit(value[i / 4][i % 4], within(path, " " + std::to_string(i)), counts);
    } else if constexpr (std::is_same_v<T, SourcePos>) {
      if (here(path, " file", counts)) value.file = FileName("edited.rib");
      edit(value.line, within(path, " line"), counts);
    } else if constexpr (std::is_same_v<T, ParameterList>) {
      if (here(path, " longer", counts)) {
        Parameter p = filled<Parameter>(7);
        p.name = "added";
        value.set(std::move(p));
      }
      const size_t count = value.size();
      if (count && here(path, " shorter", counts)) value.erase(std::string(std::as_const(value).begin()->name));
      if (isDone_) return;
      for (size_t i = 0; i < count && !isDone_; ++i) {
        // a copy of the one alone: what the others share stays shared
        auto at = std::as_const(value).begin();
        for (size_t k = 0; k < i; ++k) ++at;
        Parameter p = *at;
        const std::string name = p.name;
        edit(p, within(path, " \"" + name + "\""), counts);
        if (isDone_) *value.find(name) = std::move(p);
      }
    } else if constexpr (std::is_same_v<T, Shape>) {
      if (here(path, " of another kind", counts)) return next(value);
      std::visit([&](auto& shape) { edit(shape, path, counts); }, value);
    } else if constexpr (K::isVector) {
      if (here(path, " longer", counts)) value.push_back(filled<typename T::value_type>(9));
      if (!value.empty() && here(path, " shorter", counts)) value.pop_back();
      for (size_t i = 0; i < value.size() && !isDone_; ++i)
        if constexpr (std::is_same_v<T, InstanceList>)
          value.edit(i,
                     [&](Instance& one) { edit(one, within(path, "[" + std::to_string(i) + "]"), counts, false); });
        else
          edit(value[i], within(path, "[" + std::to_string(i) + "]"), counts, false);
    } else if constexpr (K::isArray) {
      for (size_t i = 0; i < value.size(); ++i) edit(value[i], within(path, "[" + std::to_string(i) + "]"), counts);
    } else if constexpr (K::isShared) {
      if (!value) {
        if (here(path, " made", counts)) value = filled<T>(11);
        return;
      }
      if (mayBeNull && here(path, " = none", counts)) return value.reset();
      auto copy = std::make_shared<std::remove_const_t<typename T::element_type>>(*value);
      edit(*copy, path, counts);
      if (isDone_) value = std::move(copy);
    } else if constexpr (K::isOptional) {
      if (!value) {
        if (here(path, " made", counts)) value = filled<T>(13);
        return;
      }
      if (here(path, " = none", counts)) return value.reset();
      edit(*value, path, counts);
    } else if constexpr (K::isMap) {
      if (here(path, " longer", counts)) value["added"] = filled<typename T::mapped_type>(15);
      if (!value.empty() && here(path, " shorter", counts)) value.erase(value.begin());
      if (!value.empty() && here(path, " renamed", counts)) {
        auto node = value.extract(value.begin());
        node.key() += "x";
        value.insert(std::move(node));
      }
      if (isDone_) return;
      for (auto& [key, one] : value) edit(one, within(path, " \"" + key + "\""), counts);
    } else {
      static_assert(Described<T>, "a type that stands in no list of scene/fields.h");
      forEachField(value, [&]<class F>(const F& field, typename F::Member& member) {
        edit(member, within(path, (path.empty() ? "" : ": ") + std::string(field.name)),
             counts && F::kCounts != Counts::Never);
      });
    }
  }

  template <size_t I = 0>
  static void next(Shape& shape) {
    if constexpr (I < std::variant_size_v<Shape>) {
      if ((shape.index() + 1) % std::variant_size_v<Shape> == I)
        shape.emplace<I>();
      else
        next<I + 1>(shape);
    }
  }

  const Scene scene_;
  std::vector<EditSite> sites_;
  struct Size {
    size_t sites = 0, visits = 0;
  };
  std::vector<Size> sizes_;  // of each visit of the first walk: what is below it
  size_t wanted_ = ~size_t(0), next_ = 0, visit_ = 0;
  bool isDone_ = false, isListed_ = false;
};

}  // namespace kinora::scene::test
