// Typed parameter lists: what a scene says as "[class] type[n] name" value. Used by every request that takes
// parameters. They hold values only; what a parameter means is the business of the plug-in or primitive that reads
// it.
#pragma once
#include <cstddef>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "scene/lean_vector.h"

namespace kinora::scene {

enum class StorageClass : uint8_t { Constant, Uniform, Varying, Vertex, FaceVarying, FaceVertex };
enum class ValueType : uint8_t {
  Float,
  Int,
  String,
  Color,
  Point,
  Vector,
  Normal,
  HPoint,
  Matrix,
  MPoint,
  Bxdf,
  LightFilter,
  SampleFilter,
  DisplayFilter,
  Struct  // references to nodes only
};

int componentsOf(ValueType t);       // floats an element takes: Color 3, Matrix 16, String/Int 1 ...
const char* nameOf(ValueType t);     // "color"
const char* nameOf(StorageClass c);  // "facevarying"
bool isFloatBased(ValueType t);      // true when the values are in `floats`

struct Parameter {
  std::string name;
  StorageClass storage = StorageClass::Uniform;
  ValueType type = ValueType::Float;
  bool isReference = false;  // "reference TYPE name": `strings` holds "handle:output" (or "handle")
  bool isArray = false;      // declared with [n]
  int arrayLength = 1;       // n of type[n]
  // Exactly one of the three is used, by type; flattened: elements x arrayLength x components.
  std::vector<float> floats;
  LeanVector<int> ints;
  LeanVector<std::string> strings;
  SourcePos pos;

  size_t elementFloats() const { return size_t(arrayLength) * componentsOf(type); }  // values an element takes
  size_t size() const;                                                               // values in the vector in use
};

// Parameters in order of appearance. Copies share their values until one of them is edited, so that the attributes of
// a million objects that differ in their name cost 16 bytes a parameter and object.
class ParameterList {
  template <class P, class I>
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = Parameter;
    using difference_type = std::ptrdiff_t;
    using pointer = P*;
    using reference = P&;
    Iterator() = default;
    explicit Iterator(I i) : i_(i) {}
    P& operator*() const { return **i_; }
    P* operator->() const { return i_->get(); }
    Iterator& operator++() { return ++i_, *this; }
    Iterator operator++(int) { return Iterator(i_++); }
    bool operator==(const Iterator& o) const { return i_ == o.i_; }

   private:
    I i_{};
  };
  using Storage = std::vector<std::shared_ptr<Parameter>>;

 public:
  using iterator = Iterator<Parameter, Storage::iterator>;
  using const_iterator = Iterator<const Parameter, Storage::const_iterator>;

  void set(Parameter p);  // replaces one of the same name
  const Parameter* find(std::string_view name) const;
  Parameter* find(std::string_view name);  // for editing: no longer shared with copies
  bool erase(std::string_view name);
  // First value, or the fallback when missing or of another type (an int is taken for a float and vice versa).
  float getFloat(std::string_view name, float fallback) const;
  int getInt(std::string_view name, int fallback) const;
  std::string getString(std::string_view name, std::string_view fallback) const;
  std::vector<float> getFloats(std::string_view name) const;  // empty when missing; ints converted
  bool empty() const { return list_.empty(); }
  size_t size() const { return list_.size(); }
  const_iterator begin() const { return const_iterator(list_.begin()); }
  const_iterator end() const { return const_iterator(list_.end()); }
  iterator begin();
  iterator end() { return iterator(list_.end()); }
  size_t bytes() const;  // memory held; shared values are counted by each holder

 private:
  Storage list_;
};

}  // namespace kinora::scene
