# What our comments write and Doxygen would take for a link or a tag: #V by 3, <NA>.
/\/\/\//{
    s/#([A-Za-z])/\\#\1/g
    s/@param block +A /\\p block: a /
    s/<NA>/\\<NA\\>/g
}
