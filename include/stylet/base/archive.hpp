// What an object is made of, as named columns: one pass over its members, the same to store and to load.
//
// A class has `void archive(Archive&)`, a plain struct a function of that name beside it; both name each
// member once, so what is stored and what is loaded cannot differ. Values of one name follow each other in
// one column, also those of all items of a list.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace stylet {

/// Numbers of nodes and cells in the order of the mesh's source, which is the same on any number of ranks.
struct SourceOrder {
  std::vector<int> nodes;  ///< to store: of the source, by number of the run; to load: the way back
  std::vector<int> cells;
  int dim = 2;  ///< dof = dim node + component
};

class Archive {
 public:
  struct Column {
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> values;
    std::size_t width = 1;  ///< numbers of a row
    std::size_t next = 0;   ///< to load
  };
  /// By name; / stands between the parts of a name.
  using Columns = std::map<std::string, Column>;

  /// To store.
  explicit Archive(SourceOrder order) : order_(std::move(order)) {}
  /// To load.
  Archive(SourceOrder order, Columns columns)
      : order_(std::move(order)), loads_(true), columns_(std::move(columns)) {}

  [[nodiscard]] bool loads() const { return loads_; }
  [[nodiscard]] const Columns& columns() const { return columns_; }
  [[nodiscard]] const SourceOrder& order() const { return order_; }
  /// Throws InputError if something stored was not loaded.
  void finish() const;

  /// A number, a text, a choice, an optional, a list, or what has an `archive` of its own. Throws InputError
  /// where what is to be loaded is not there, of another kind or no number, NumericalError to store none.
  template <class T>
  void operator()(const std::string& name, T& value) {
    const Below below(*this, name);
    item(value);
  }
  /// Numbers of nodes, dofs or cells; negative ones stay.
  void node(const std::string& name, int& number);
  void nodes(const std::string& name, std::vector<int>& numbers);
  void dof(const std::string& name, int& number);
  void cell(const std::string& name, int& number);
  void cells(const std::string& name, std::vector<int>& numbers);
  /// As many numbers as there are, `width` a row.
  void array(const std::string& name, std::span<double> values, std::size_t width);
  void array(const std::string& name, std::span<int> values, std::size_t width);

 private:
  class Below {
   public:
    Below(Archive& archive, const std::string& name)
        : archive_(archive), length_(archive.path_.size()) {
      archive.path_ += (length_ == 0 ? "" : "/") + name;
    }
    Below(const Below&) = delete;
    Below& operator=(const Below&) = delete;
    ~Below() { archive_.path_.resize(length_); }

   private:
    Archive& archive_;
    std::size_t length_;
  };

  template <class T>
  struct IsVector : std::false_type {};
  template <class T>
  struct IsVector<std::vector<T>> : std::true_type {};
  template <class T>
  struct IsOptional : std::false_type {};
  template <class T>
  struct IsOptional<std::optional<T>> : std::true_type {};

  template <class T>
  void item(T& value) {
    if constexpr (std::is_enum_v<T> || std::is_integral_v<T>) {
      auto number = static_cast<std::int64_t>(value);
      scalar(number);
      value = static_cast<T>(number);
    } else if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::string>) {
      scalar(value);
    } else if constexpr (IsOptional<T>::value) {
      bool given = value.has_value();
      (*this)("given", given);
      if (loads_) value = given ? std::optional(typename T::value_type{}) : std::nullopt;
      if (given) (*this)("value", *value);
    } else if constexpr (IsVector<T>::value) {
      std::size_t size = value.size();
      (*this)("size", size);
      if (loads_) value = T(size);
      for (auto& each : value) (*this)("each", each);
    } else if constexpr (requires { value.archive(*this); }) {
      value.archive(*this);
    } else {
      archive(*this, value);
    }
  }

  void scalar(double& value);
  void scalar(std::int64_t& value);
  void scalar(std::string& value);
  template <class T>
  void next(T& value);
  template <class T>
  void fixed(std::span<T> values, std::size_t width);
  [[noreturn]] void refuse(const std::string& why) const;
  [[nodiscard]] int renumbered(const std::vector<int>& order, int number) const;

  SourceOrder order_;
  bool loads_ = false;
  Columns columns_;
  std::string path_;
};

}  // namespace stylet
