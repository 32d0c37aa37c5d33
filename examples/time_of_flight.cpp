// time_of_flight.c in C++17: what a make function made is freed by its free function when it goes out of scope, and a
// status that is not SP_OK becomes an exception with the library's reason.
#include <sonopack/sonopack.h>

#include <cstdio>
#include <stdexcept>
#include <utility>

namespace {

// A struct of the library with its owner. None() is its empty value, which Free takes as well.
template <typename T, T (*None)(), void (*Free)(T *)> class owned {
  public:
    owned() = default;
    ~owned() { Free(&value_); }
    owned(owned &&other) noexcept : value_(std::exchange(other.value_, None())) {}
    owned &operator=(owned &&other) noexcept {
        std::swap(value_, other.value_);
        return *this;
    }
    owned(const owned &) = delete;
    owned &operator=(const owned &) = delete;
    T *get() { return &value_; }
    const T *get() const { return &value_; }
    const T *operator->() const { return &value_; }

  private:
    T value_ = None();
};

using packing = owned<sp_packing, sp_packing_none, sp_packing_free>;
using network = owned<sp_network, sp_network_none, sp_network_free>;
using signal_of_wall = owned<sp_signal, sp_signal_none, sp_signal_free>;

// Calls f(arguments..., &err) and throws the reason unless it went well.
template <typename F, typename... Arguments> void must(F f, Arguments... arguments) {
    sp_error err{};
    if (f(arguments..., &err) != SP_OK)
        throw std::runtime_error(err.text);
}

packing make_packing(int32_t grains, double pressure) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = grains;
    spec.width = 10.0;
    spec.pressure = pressure;
    spec.protocol = SP_PROTOCOL_QUICK;
    packing made;
    must(sp_packing_make, &spec, nullptr, nullptr, made.get());
    return made;
}

double arrival_time(const packing &p) {
    const sp_network_options network_options = sp_network_options_default();
    const sp_front_options front_options = sp_front_options_default();
    sp_signal_options signal_options = sp_signal_options_default();
    signal_options.until = sp_signal_window(sp_packing_height(p.get()), p->pressure);
    signal_options.points = 2000;
    network net;
    signal_of_wall signal;
    sp_front front{};
    must(sp_network_make, p.get(), &network_options, net.get());
    must(sp_signal_make, net.get(), &signal_options, signal.get());
    must(sp_front_find, signal->n, signal->t, signal->f, &front_options, &front);
    return front.t10;
}

} // namespace

int main() try {
    const double pressure = 1e-4; // [E*]
    const packing low = make_packing(80, pressure), high = make_packing(240, pressure);
    const double rise = sp_packing_height(high.get()) - sp_packing_height(low.get());
    const double speed = rise / (arrival_time(high) - arrival_time(low));
    std::printf("speed of the front at p = %g E*: %.4f sqrt(E*/rho)\n", pressure, speed);
    return 0;
} catch (const std::exception &reason) {
    std::fprintf(stderr, "%s\n", reason.what());
    return 1;
}
