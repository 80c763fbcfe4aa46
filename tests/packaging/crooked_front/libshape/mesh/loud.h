namespace shape {
}
