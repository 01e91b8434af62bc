(printout t "files go" crlf)
