// Faults that C++ adds to those of C, one for each torque reference; the line of each has its name in a comment.
#include "drivegate_duty.h"
#include <cstring>
#include <memory>
#include <vector>

struct Gain {
    virtual ~Gain() = default;
    virtual double of(double value) const { return value; }
};
struct Other {
    virtual ~Other() = default;
    virtual double other() const { return 1.0; }
};
struct Observer {
    double angle, gain = 2.0;
    explicit Observer(bool is_warm) {
        if (is_warm) angle = 0.0;
    }
    double answer() const { return gain * angle; } // member that no constructor wrote
};
struct Controller {
    double *allocated;
    std::vector<double> *table;
    double *released;
    Gain gain;
    Other other;
};

static Controller controller;

int64_t drivegate_abi_version() { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size() { return 0; }

int drivegate_duty_reset(void *, const drivegate_duty_nameplate *) {
    controller.allocated = new double[4];
    controller.table = new std::vector<double>(4, 0.5);
    auto gone = std::make_unique<double>(1.0);
    controller.released = gone.get();
    return 0;
}

void drivegate_duty_step(void *, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    volatile int number = static_cast<int>(10.0 * sense->reference + 0.5);
    for (double &ratio : command->duty_ratios) ratio = 0.5;
    command->torque = 0.0;
    if (sense->time < 0.001) return;
    const void *other = &controller.other;
    unsigned char two = 2;
    bool is_on;
    std::memcpy(&is_on, &two, 1);
    switch (number) {
    case 1: command->torque = (*controller.table)[static_cast<size_t>(number + 3)]; break; // past a vector
    case 2: command->torque = *controller.released; break; // use after it is deleted
    case 3: command->torque = static_cast<const Gain *>(other)->of(1.0); break; // object of another type
    case 4: command->torque = is_on ? 1.0 : 0.0; break; // no truth value
    case 5: command->torque = Observer(number > 5).answer(); break;
    case 6: command->torque = controller.allocated[2]; break;
    default: break;
    }
}
