// SPDX-License-Identifier: MIT
// What differs between operating systems. The folders of libbase/src named after systems implement
// it; other code knows no system.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Functions that fail return -1, false or null, with the reason in errno.
namespace silvafit::system {

/// Opens a file. \return its descriptor
int open_to_read(const std::filesystem::path& file);
/// Opens what exists, such as a device, to write at its end. \return its descriptor
int open_to_append(const std::filesystem::path& file);
/// Makes a file, for reading and writing. It fails if the name exists, also as a link.
/// \param permissions  before the umask of the process is applied
/// \return its descriptor
int open_new(const std::filesystem::path& file, std::filesystem::perms permissions);
/// As open_new(), but nobody else may use the file, and it is deleted when it is closed.
std::FILE* open_nameless(const std::filesystem::path& file);

/// Reads or writes at most so many bytes. \return how many; 0 at the end of a file
std::ptrdiff_t read(int descriptor, char* bytes, std::size_t count);
std::ptrdiff_t write(int descriptor, const char* bytes, std::size_t count);
bool close(int descriptor);
/// The size of a file [bytes]; nothing for devices and pipes.
std::optional<std::uint64_t> file_size(int descriptor);
bool set_permissions(int descriptor, std::filesystem::perms permissions);
/// Waits until the bytes are on the disk. A file system without this function is no error.
bool flush_to_disk(int descriptor);
/// As flush_to_disk(), for the names in a folder. Unreadable folders are left to the system.
bool flush_folder(const std::filesystem::path& folder);

/// Makes a folder that nobody else may use.
bool make_own_folder(const std::filesystem::path& folder);
/// Locks a folder until the lock is destroyed or the process ends. A file system without locks is
/// no error.
/// \return false if another lock holds it
bool lock_folder(const std::filesystem::path& folder, std::shared_ptr<void>& lock);

/// The reason of a failure, and what helps.
std::string reason(int error_number);

/// The words of the command line in UTF-8, the program first.
std::vector<std::string> command_line(int argc, char** argv);
/// Opens closed standard streams such that reading and writing them fails: otherwise the next
/// opened file would get their number, and notes would be written into results. Texts are UTF-8,
/// and bytes are written unchanged. Call it first.
void prepare_standard_streams();
bool is_terminal(std::FILE* stream);
/// Redirects a standard stream to nowhere. \return a descriptor of what it was
int silence(std::FILE* stream);
/// Redirects a standard stream to a descriptor of silence().
void restore(std::FILE* stream, int descriptor);

/// After this call an interrupt (Ctrl-C, the end of the session) first calls the function, on a
/// thread of its own, and then ends the process as usual. Call it once, before any other thread is
/// started.
void clean_up_on_interrupts(void (*clean_up)());
/// Gives a thread the arithmetic of the first one, so that results do not depend on the thread.
void prepare_thread();
/// Keeps freed memory in the process. A fit allocates and frees arrays of some MB in each pass over
/// the data. Returning them to the system costs one page fault per page and interrupts the other
/// threads.
void keep_freed_memory();

/// The file of this program; empty if it is unknown.
std::filesystem::path program_file();
bool has_desktop();
/// Whether a desktop names files that are dropped on the program as words of its command line.
bool takes_dropped_files();
/// Whether the program has a console window of its own, which closes when it ends.
bool has_own_console();
/// Opens a page on the desktop. \return whether this succeeded
bool open_in_browser(const std::filesystem::path& page);

}  // namespace silvafit::system
