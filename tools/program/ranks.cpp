// SPDX-License-Identifier: MIT

#include "tools/program/ranks.h"

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "tools/program/arguments.h"

#ifdef SHAPE_WITH_MPI
#define OMPI_SKIP_MPICXX 1 // its interface of C alone
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <vector>
#endif

namespace shape::tools {
using namespace internal;
namespace {

/// How many processes were started together; 0: this was started alone.
int started_together()
{
    for (const char* const name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
        if (const char* const size = std::getenv(name))
            return std::atoi(size);
    return 0;
}

/// The process that speaks.
struct FirstProcess
{
    long id = 0;
    bool is_elsewhere = false; ///< On another machine.
};

FirstProcess first_process;

bool is_gone(long process)
{
    return ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
}

Ranks& own_ranks()
{
    static Ranks ranks;
    return ranks;
}

#ifdef SHAPE_WITH_MPI

bool is_joined = false;

/// Tells all processes which one is the first.
void introduce_first_process()
{
    long facts[2] = {static_cast<long>(::getpid()), ::gethostid()};
    const long host = facts[1];
    MPI_Bcast(facts, 2, MPI_LONG, 0, MPI_COMM_WORLD);
    first_process = {facts[0], facts[1] != host};
}

/// Sends numbers to a process and receives as many. One that is waited for may have been killed: mpirun then
/// tells the others to stop.
void exchange(std::span<double> numbers, std::span<double> other, int partner)
{
    const auto count = static_cast<int>(numbers.size());
    MPI_Request requests[2];
    MPI_Irecv(other.data(), count, MPI_DOUBLE, partner, 0, MPI_COMM_WORLD, &requests[0]);
    MPI_Isend(numbers.data(), count, MPI_DOUBLE, partner, 0, MPI_COMM_WORLD, &requests[1]);
    for (int are_done = 0; are_done == 0;) {
        MPI_Testall(2, requests, &are_done, MPI_STATUSES_IGNORE);
        throw_if_stop_requested();
    }
}

/// Combines the numbers of all processes: each time with those of the process whose number differs in one
/// bit, the highest first. Both get the same, for the order of two does not matter.
template <class Combine>
void combine(std::span<double> numbers, const Combine& with)
{
    constexpr std::size_t piece = std::size_t{1} << 20;
    std::vector<double> other(std::min(piece, numbers.size()));
    const Ranks& ranks = own_ranks();
    for (int bit = ranks.count / 2; bit > 0; bit /= 2)
        for (std::size_t first = 0; first < numbers.size(); first += piece) {
            const std::size_t count = std::min(piece, numbers.size() - first);
            exchange(numbers.subspan(first, count), other, ranks.number ^ bit);
            for (std::size_t i = 0; i < count; ++i)
                numbers[first + i] = with(numbers[first + i], other[i]);
        }
}

#endif

} // namespace

const Ranks& ranks()
{
    return own_ranks();
}

void join_ranks()
{
    const int count = started_together();
    if (count == 0)
        return;
#ifdef SHAPE_WITH_MPI
    int level = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
    is_joined = true;
    Ranks& own = own_ranks();
    MPI_Comm_rank(MPI_COMM_WORLD, &own.number);
    MPI_Comm_size(MPI_COMM_WORLD, &own.count);
    introduce_first_process();
    if ((own.count & (own.count - 1)) != 0)
        throw UsageError(join("mpirun has started ", own.count,
                              " processes; their number must be a power of two"));
    own.partial_sums = std::max(own.count, 4);
    own.all_reduce_sum = [](std::span<double> numbers) {
        combine(numbers, [](double a, double b) { return a + b; });
    };
    own.all_reduce_max = [](std::span<double> numbers) {
        combine(numbers, [](double a, double b) { return std::max(a, b); });
    };
#else
    if (count > 1)
        throw UsageError(
            "this program was built without MPI (-DSHAPE_WITH_MPI=ON): mpirun would "
            "start it several times over, each doing the same");
#endif
}

int leave_ranks(int exit_code)
{
#ifdef SHAPE_WITH_MPI
    if (is_joined && exit_code != 0 && own_ranks().count > 1)
        MPI_Abort(MPI_COMM_WORLD, exit_code);
    if (is_joined)
        MPI_Finalize();
#endif
    return exit_code;
}

bool is_to_speak(bool is_interrupted)
{
    using std::chrono::milliseconds;
    const int number = own_ranks().number;
    if (number == 0)
        return true;
    const bool is_next = number == 1 && is_interrupted;
    for (int tenth = 0; tenth < (is_interrupted ? 10 : 20); ++tenth) {
        if (is_next && (first_process.is_elsewhere ? tenth == 5 : is_gone(first_process.id)))
            return true;
        std::this_thread::sleep_for(milliseconds(100));
    }
    return !is_interrupted;
}

void wait_for_ranks()
{
    double nothing = 0.0;
    own_ranks().all_reduce_sum({&nothing, 1});
}

} // namespace shape::tools
